// writers.lod2 in PDAL: hands the points of a pipeline to gable, which reconstructs the buildings and writes a city model.
//
// The options are those of the stage of that name in `gable pipeline`. They come from the library, help texts included, and
// go back to it as they were given: what they accept is checked there, and told in the same words.
//
// License: MIT OR Apache-2.0.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gable.h>
#include <pdal/PointView.hpp>
#include <pdal/Streamable.hpp>
#include <pdal/Writer.hpp>
#include <pdal/pdal_features.hpp>
#include <pdal/util/ProgramArgs.hpp>

namespace
{

using pdal::Dimension::Id;

// Points that are handed over at once.
constexpr std::size_t ChunkSize = 65536;

// Since 2.7 writers have an option "filename" of their own, unless they say that they have none: ours is among gable's.
#if PDAL_VERSION_MAJOR > 2 || PDAL_VERSION_MINOR >= 7
using Base = pdal::NoFilenameWriter;
#else
using Base = pdal::Writer;
#endif

// Bits of a point's flags, in gable_chunk and in PDAL's ClassFlags alike.
constexpr uint8_t Synthetic = 1, Withheld = 4, Overlap = 8;

struct Free
{
    void operator()(gable_job *job) const { gable_free(job); }
};

using Job = std::unique_ptr<gable_job, Free>;

// An option with what was given for it. PDAL keeps references to the values.
struct Option
{
    const gable_option *told = nullptr;
    const pdal::Arg *arg = nullptr;
    std::string text;
    std::vector<std::string> list;
};

// Columns of points, as gable takes them.
struct Columns
{
    std::vector<double> x, y, z;
    std::vector<uint8_t> classification, returnNumber, flags;

    void clear()
    {
        for (auto *column : {&x, &y, &z})
            column->clear();
        for (auto *column : {&classification, &returnNumber, &flags})
            column->clear();
    }
};

// The dimensions that gable wants to know; a point without one has 0 there.
struct Dimensions
{
    Id classification, returnNumber, synthetic, withheld, overlap, classFlags;

    explicit Dimensions(const pdal::PointLayout& layout)
    {
        classification = layout.findDim("Classification");
        returnNumber = layout.findDim("ReturnNumber");
        synthetic = layout.findDim("Synthetic");
        withheld = layout.findDim("Withheld");
        overlap = layout.findDim("Overlap");
        // Before 2.6 the flags were one dimension.
        const bool parted = synthetic != Id::Unknown || withheld != Id::Unknown || overlap != Id::Unknown;
        classFlags = parted ? Id::Unknown : layout.findDim("ClassFlags");
    }
};

uint8_t byteAt(const pdal::PointRef& point, Id dimension)
{
    if (dimension == Id::Unknown)
        return 0;
    const double value = point.getFieldAs<double>(dimension);
    return static_cast<uint8_t>(value > 0 ? std::min(value, 255.0) : 0.0);
}

// As JSON. Bytes that are no UTF-8 stay, so that gable can say so.
std::string quoted(const std::string& text)
{
    std::string json("\"");
    for (const char c : text)
    {
        if (c == '"' || c == '\\')
            (json += '\\') += c;
        else if (static_cast<unsigned char>(c) < 0x20)
            ((json += "\\u00") += "01"[c >> 4]) += "0123456789abcdef"[c & 15];
        else
            json += c;
    }
    return json + '"';
}

pdal::PluginInfo const info
{
    "writers.lod2",
    "Reconstruct buildings and write a city model (CityJSON, 3D Tiles, GeoPackage, OBJ)",
    "https://docs.rs/gable"
};

} // unnamed namespace

class Lod2Writer : public Base, public pdal::Streamable
{
public:
    std::string getName() const override { return info.name; }

private:
    void addArgs(pdal::ProgramArgs& args) override
    {
        if (m_given.empty())
        {
            std::size_t count = 0;
            const gable_option *options = gable_writer_options(&count);
            m_given.resize(count);
            for (std::size_t i = 0; i < count; ++i)
                m_given[i].told = options + i;
        }
        for (Option& option : m_given)
        {
            const std::string name(option.told->name), help(option.told->help);
            const char *byDefault = option.told->default_value;
            pdal::Arg& arg = option.told->is_list ?
                (byDefault ? args.add(name, help, option.list, pdal::StringList{byDefault}) : args.add(name, help, option.list)) :
                (byDefault ? args.add(name, help, option.text, byDefault) : args.add(name, help, option.text));
            if (option.told->is_required)
                arg.setPositional();
            option.arg = &arg;
        }
    }

    // Before any point is read: options that are of no use, and a file that must not be replaced.
    void initialize() override
    {
        m_hasCrs = false;
        m_options.clear();
        for (const Option& option : m_given)
        {
            if (!option.arg->set())
                continue;
            m_hasCrs = m_hasCrs || std::string(option.told->name) == "crs";
            std::string value = quoted(option.text);
            if (option.told->is_list)
            {
                value.clear();
                for (const std::string& item : option.list)
                    value += (value.empty() ? "" : ",") + quoted(item);
                value = '[' + value + ']';
            }
            m_options += (m_options.empty() ? "" : ",") + quoted(option.told->name) + ':' + value;
        }
        m_options = '{' + m_options + '}';
        create(pdal::SpatialReference());
    }

    void ready(pdal::PointTableRef table) override
    {
        m_job.reset();
        m_columns.clear();
        m_dimensions = std::make_unique<Dimensions>(*table.layout());
    }

    // Standard mode: views come one by one.
    void write(const pdal::PointViewPtr view) override
    {
        if (view->empty())
            return;
        spatialReferenceChanged(view->spatialReference());
        pdal::PointRef point(*view, 0);
        for (pdal::PointId i = 0; i < view->size(); ++i)
        {
            point.setPointId(i);
            processOne(point);
        }
    }

    // Stream mode: points come one by one.
    bool processOne(pdal::PointRef& point) override
    {
        const Dimensions& dimensions = *m_dimensions;
        m_columns.x.push_back(point.getFieldAs<double>(Id::X));
        m_columns.y.push_back(point.getFieldAs<double>(Id::Y));
        m_columns.z.push_back(point.getFieldAs<double>(Id::Z));
        m_columns.classification.push_back(byteAt(point, dimensions.classification));
        m_columns.returnNumber.push_back(byteAt(point, dimensions.returnNumber));
        const int flags = (byteAt(point, dimensions.synthetic) ? Synthetic : 0) |
            (byteAt(point, dimensions.withheld) ? Withheld : 0) | (byteAt(point, dimensions.overlap) ? Overlap : 0) |
            (byteAt(point, dimensions.classFlags) & (Synthetic | Withheld | Overlap));
        m_columns.flags.push_back(static_cast<uint8_t>(flags));
        if (m_columns.x.size() == ChunkSize)
            push();
        return true;
    }

    void spatialReferenceChanged(const pdal::SpatialReference& crs) override
    {
        if (!m_job)
        {
            m_crs = crs;
            m_job = create(crs);
        }
        else if (crs != m_crs && !m_hasCrs)
        {
            const auto name = [](const pdal::SpatialReference& crs) { return crs.empty() ? "no CRS" : crs.getName(); };
            throwError("found points in " + name(crs) + " among points in " + name(m_crs) +
                ", expected points of one CRS. Put filters.reprojection before");
        }
    }

    void done(pdal::PointTableRef table) override
    {
        if (!m_job)
            m_job = create(table.anySpatialReference());
        push();
        m_stage = -1;
        const gable_status status = gable_run(m_job.get(), nullptr, progress, this);
        for (std::size_t i = 0; const char *warning = part("/warnings/" + std::to_string(i)); ++i)
            log()->get(pdal::LogLevel::Warning) << warning << std::endl;
        if (status == GABLE_STATUS_INCOMPLETE)
            log()->get(pdal::LogLevel::Warning) << gable_error(m_job.get()) << std::endl;
        else
            check(m_job.get(), status);
        for (const auto& [name, pointer] : {std::pair{"filename", "/outputs"}, {"counts", "/counts"}, {"exit_code", "/exit_code"}})
            if (const char *value = part(pointer))
                m_metadata.addWithType(name, value, "json", "");
        m_job.reset();
    }

    // A job with the options that were given.
    Job create(const pdal::SpatialReference& crs) const
    {
        gable_job *created = nullptr;
        const gable_status status = gable_create_writer(m_options.c_str(), crs.getWKT().c_str(), &created);
        Job job(created);
        check(created, status);
        return job;
    }

    void push()
    {
        if (m_columns.x.empty())
            return;
        gable_chunk chunk = {};
        chunk.struct_size = sizeof chunk;
        chunk.count = m_columns.x.size();
        chunk.x = m_columns.x.data();
        chunk.y = m_columns.y.data();
        chunk.z = m_columns.z.data();
        chunk.classification = m_columns.classification.data();
        chunk.return_number = m_columns.returnNumber.data();
        chunk.flags = m_columns.flags.data();
        check(m_job.get(), gable_push(m_job.get(), &chunk));
        m_columns.clear();
    }

    const char *part(const std::string& pointer) const
    {
        return gable_report_part(m_job.get(), pointer.c_str());
    }

    void check(const gable_job *job, gable_status status) const
    {
        if (status != GABLE_STATUS_OK)
            throwError(gable_error(job));
    }

    // No exception may pass through gable.
    static int progress(gable_stage stage, uint64_t, uint64_t total, void *writer) noexcept
    {
        static const char *const units[] = {"files to read", "points to give to buildings", "buildings", "files to complete"};
        try
        {
            auto *self = static_cast<Lod2Writer *>(writer);
            if (std::exchange(self->m_stage, stage) != stage)
                self->log()->get(pdal::LogLevel::Info) << total << ' ' << units[stage] << std::endl;
        }
        catch (...)
        {
        }
        return 0;
    }

    std::vector<Option> m_given;
    // As JSON.
    std::string m_options;
    bool m_hasCrs = false;
    std::unique_ptr<Dimensions> m_dimensions;
    Columns m_columns;
    pdal::SpatialReference m_crs;
    // Of the run; -1 before.
    int m_stage = -1;
    Job m_job;
};

CREATE_SHARED_STAGE(Lod2Writer, info)
