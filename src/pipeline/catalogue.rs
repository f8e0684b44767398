//! The stages that there are.

use std::path::Path;

use super::nearest::nearest;
use super::options::Place;
use super::stage::{Role, StageKind};
use super::stages;
use crate::error::InputError;
use crate::sink::Format;

/// All types of stages that gable has, by role and name.
pub const STAGES: &[StageKind] = &[
    stages::las_reader::KIND,
    stages::copc_reader::KIND,
    stages::ept_reader::KIND,
    stages::ply_reader::KIND,
    stages::text_reader::KIND,
    stages::lod2_reader::KIND,
    stages::assign::KIND,
    stages::cluster::KIND,
    stages::crop::KIND,
    stages::csf::KIND,
    stages::decimation::KIND,
    stages::expression::KIND,
    stages::ferry::KIND,
    stages::hag_delaunay::KIND,
    stages::hag_nn::KIND,
    stages::head::KIND,
    stages::merge::KIND,
    stages::outlier::KIND,
    stages::overlay::KIND,
    stages::range::KIND,
    stages::reprojection::KIND,
    stages::returns::KIND,
    stages::sample::KIND,
    stages::smrf::KIND,
    stages::sort::KIND,
    stages::splitter::KIND,
    stages::stats::KIND,
    stages::tail::KIND,
    stages::copc_writer::KIND,
    stages::las_writer::KIND,
    stages::lod2_writer::KIND,
    stages::text_writer::KIND,
    stages::null_writer::KIND,
];

/// Types of stages that PDAL 2.9 has and gable has not; those that come as plug-ins included.
const ELSEWHERE: &[&str] = &[
    "readers.arrow",
    "readers.bpf",
    "readers.buffer",
    "readers.draco",
    "readers.e57",
    "readers.faux",
    "readers.fbi",
    "readers.gdal",
    "readers.hdf",
    "readers.i3s",
    "readers.ilvis2",
    "readers.matlab",
    "readers.mbio",
    "readers.memoryview",
    "readers.numpy",
    "readers.obj",
    "readers.optech",
    "readers.pcd",
    "readers.pgpointcloud",
    "readers.pts",
    "readers.ptx",
    "readers.qfit",
    "readers.rdb",
    "readers.rxp",
    "readers.sbet",
    "readers.slpk",
    "readers.smrmsg",
    "readers.spz",
    "readers.stac",
    "readers.terrasolid",
    "readers.tiledb",
    "readers.tindex",
    "readers.nitf",
    "filters.approximatecoplanar",
    "filters.chipper",
    "filters.colorinterp",
    "filters.colorization",
    "filters.covariancefeatures",
    "filters.cpd",
    "filters.dbscan",
    "filters.delaunay",
    "filters.dem",
    "filters.divider",
    "filters.eigenvalues",
    "filters.elm",
    "filters.estimaterank",
    "filters.expressionstats",
    "filters.faceraster",
    "filters.fps",
    "filters.geomdistance",
    "filters.georeference",
    "filters.gpstimeconvert",
    "filters.greedyprojection",
    "filters.griddecimation",
    "filters.gridprojection",
    "filters.groupby",
    "filters.h3",
    "filters.hag_dem",
    "filters.hexbin",
    "filters.icp",
    "filters.info",
    "filters.iqr",
    "filters.julia",
    "filters.label_duplicates",
    "filters.litree",
    "filters.lloydkmeans",
    "filters.locate",
    "filters.lof",
    "filters.mad",
    "filters.matlab",
    "filters.miniball",
    "filters.mongo",
    "filters.mortonorder",
    "filters.neighborclassifier",
    "filters.nndistance",
    "filters.normal",
    "filters.optimalneighborhood",
    "filters.planefit",
    "filters.pmf",
    "filters.poisson",
    "filters.projpipeline",
    "filters.python",
    "filters.radialdensity",
    "filters.radiusassign",
    "filters.randomize",
    "filters.reciprocity",
    "filters.relaxationdartthrowing",
    "filters.separatescanline",
    "filters.shell",
    "filters.skewnessbalancing",
    "filters.sparsesurface",
    "filters.straighten",
    "filters.streamcallback",
    "filters.supervoxel",
    "filters.teaser",
    "filters.transformation",
    "filters.trajectory",
    "filters.voxelcenternearestneighbor",
    "filters.voxelcentroidnearestneighbor",
    "filters.voxeldownsize",
    "filters.zsmooth",
    "writers.arrow",
    "writers.bpf",
    "writers.draco",
    "writers.e57",
    "writers.ept_addon",
    "writers.fbi",
    "writers.gdal",
    "writers.gltf",
    "writers.ogr",
    "writers.pcd",
    "writers.pgpointcloud",
    "writers.ply",
    "writers.raster",
];

/// File name extensions that mean a stage of PDAL that gable has not.
const EXTENSIONS_ELSEWHERE: &[(&str, Role, &str)] = &[
    ("bpf", Role::Reader, "readers.bpf"),
    ("bpf", Role::Writer, "writers.bpf"),
    ("e57", Role::Reader, "readers.e57"),
    ("gltf", Role::Writer, "writers.gltf"),
    ("pcd", Role::Reader, "readers.pcd"),
    ("pcd", Role::Writer, "writers.pcd"),
    ("ply", Role::Writer, "writers.ply"),
    ("pts", Role::Reader, "readers.pts"),
    ("tif", Role::Reader, "readers.gdal"),
    ("tif", Role::Writer, "writers.gdal"),
    ("tiff", Role::Writer, "writers.gdal"),
];

/// The type of stages of this name.
///
/// # Errors
/// There is none; the error names the nearest, or says that PDAL has it.
pub fn find(name: &str, place: &Place) -> Result<&'static StageKind, InputError> {
    if let Some(kind) = STAGES.iter().find(|kind| kind.name == name) {
        return Ok(kind);
    }
    if ELSEWHERE.contains(&name) {
        return Err(elsewhere(name, place));
    }
    let near = nearest(name, STAGES.iter().map(|kind| kind.name).chain(ELSEWHERE.iter().copied()));
    let expected = near.map_or("a type of stages that `gable stages` lists".to_owned(), |near| format!("`{near}`"));
    let found = format!("the type `{name}`, which is unknown");
    Err(place.fault(found, expected).remedy("`gable stages` lists the stages that gable has"))
}

/// The refusal of a stage that PDAL has.
fn elsewhere(name: &str, place: &Place) -> InputError {
    place.fault(format!("`{name}`, which PDAL has and gable has not"), "a stage that `gable stages` lists").remedy(
        "Run the file in PDAL (`pdal pipeline FILE`) up to here, let writers.las write the points, and hand that file to \
         gable",
    )
}

/// The type of stages that a file name means.
///
/// # Errors
/// The extension means none.
pub fn infer(filename: &str, role: Role, place: &Place) -> Result<&'static StageKind, InputError> {
    let name = Path::new(filename).file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let ends = |extension: &str| name.strip_suffix(extension).is_some_and(|rest| rest.ends_with('.'));
    // A file of that name is text to PDAL, and only the longer extension makes it a city model.
    let is_model = (ends("city.json") || !ends("json")) && Format::of(Path::new(filename)).is_ok();
    let kind = match role {
        // A folder is one of tiles, unless a type says otherwise.
        Role::Reader if Path::new(filename).is_dir() => Some("readers.las"),
        Role::Reader if ends("copc.laz") => Some("readers.copc"),
        Role::Reader if name == "ept.json" || filename.starts_with("ept://") => Some("readers.ept"),
        Role::Reader if ends("las") || ends("laz") => Some("readers.las"),
        Role::Reader if ends("ply") => Some("readers.ply"),
        Role::Reader if ["csv", "txt", "xyz"].iter().any(|extension| ends(extension)) => Some("readers.text"),
        Role::Reader if ends("city.json") || ends("city.jsonl") => Some("readers.lod2"),
        Role::Writer if is_model => Some("writers.lod2"),
        Role::Writer if ends("copc.laz") => Some("writers.copc"),
        Role::Writer if ends("las") || ends("laz") => Some("writers.las"),
        Role::Writer if ["csv", "txt", "json", "xyz"].iter().any(|extension| ends(extension)) => Some("writers.text"),
        _ => None,
    };
    if let Some(kind) = kind {
        return find(kind, place);
    }
    if let Some((_, _, name)) = EXTENSIONS_ELSEWHERE.iter().find(|(extension, of, _)| *of == role && ends(extension)) {
        return Err(elsewhere(name, place));
    }
    let expected = match role {
        Role::Reader => ".las, .laz, .copc.laz, .ply, .csv, .txt, .xyz, .city.json or .city.jsonl",
        _ => ".las, .laz, .copc.laz, .csv, .txt, or the extension of a city model such as .city.json",
    };
    let fault = place.fault(format!("`{filename}`, whose extension means no stage"), expected);
    Err(fault.remedy("Give a `type`; `gable stages` lists them"))
}
