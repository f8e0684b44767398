/* gable: airborne laser points and building footprints in, valid LoD 2 city models out.
 *
 * Create a job from options, push points to it, run it, free it:
 *
 *     gable_job *job;
 *     if (gable_create("{\"output\": \"house.city.json\"}", "EPSG:7415", &job) == GABLE_STATUS_OK) {
 *         gable_chunk chunk = {0};
 *         chunk.struct_size = sizeof chunk;
 *         chunk.count = n;
 *         chunk.x = x, chunk.y = y, chunk.z = z, chunk.classification = classification;
 *         gable_push(job, &chunk);                 // again for every chunk
 *         gable_run(job, NULL, NULL, NULL);
 *     }
 *     puts(gable_error(job));
 *     gable_free(job);
 *
 * Errors: every call says by its status whether it was done, and gable_error why not. Null pointers, columns that are
 * missing or misaligned, numbers that are none and text that is not UTF-8 are errors; a pointer to memory that is not
 * yours, a count larger than a column, and a job that was freed cannot be noticed.
 *
 * Threads: jobs are independent of one another. One job is used by one thread at a time; a second gets GABLE_STATUS_BUSY.
 * A run uses as many threads as the option "jobs" says and calls back on the thread that called gable_run only.
 *
 * Text is UTF-8 and ends with a zero. What you pass is copied or read during the call and stays yours; what you get
 * belongs to the library.
 *
 * Made from src/capi by cbindgen: do not edit. License: MIT OR Apache-2.0.
 */

#ifndef GABLE_H
#define GABLE_H

#include <stddef.h>
#include <stdint.h>

// What came of a call.
typedef enum gable_status {
  // Done. After gable_run: every footprint that holds points has a model.
  GABLE_STATUS_OK = 0,
  // Nothing could be done; gable_error says why.
  GABLE_STATUS_FAILED = 1,
  // The run finished and wrote what there is, but some buildings lack a model or some points could not be read;
  // gable_report says which and why.
  GABLE_STATUS_INCOMPLETE = 2,
  // The run finished, but no building has a model; gable_report says why.
  GABLE_STATUS_EMPTY = 3,
  // A callback stopped the run. What was done until then was written and handed over.
  GABLE_STATUS_CANCELLED = 4,
  // The job is in use: by another thread, or the call came from one of its own callbacks. Nothing was done.
  GABLE_STATUS_BUSY = 5,
} gable_status;

// The stages of a run, in order; the terrain is made before the output is completed.
typedef enum gable_stage {
  // Reads footprints and what the points are; counted in files.
  GABLE_STAGE_READ = 0,
  // Gives the points to the buildings that they belong to; counted in points.
  GABLE_STAGE_SEGMENT = 1,
  // Reconstructs the buildings; counted in buildings.
  GABLE_STAGE_RECONSTRUCT = 2,
  // Completes the output; counted in files.
  GABLE_STAGE_FINISH = 3,
  // Makes the terrain, if the job asks for it; counted in tiles.
  GABLE_STAGE_TERRAIN = 4,
  // Writes the points of each building to a file of its own, before the output is completed; counted in points.
  GABLE_STAGE_CROP = 5,
} gable_stage;

// A job: options, points, and what came of them. Only pointers to it are used; gable_create makes one and gable_free
// takes it back.
typedef struct gable_job gable_job;

// A chunk of points, as columns of the same length. Set all of it to zero first (`gable_chunk chunk = {0};`): a column
// that is NULL is not there. The columns are read during the call and stay yours.
typedef struct gable_chunk {
  // sizeof(gable_chunk): tells which columns you know of, so that later versions may add some at the end.
  size_t struct_size;
  // Number of points: the length of every column.
  size_t count;
  // Coordinates in the units of the CRS, easting or its like first. Required; finite.
  const double *x;
  // See x.
  const double *y;
  // See x.
  const double *z;
  // ASPRS classes (2 ground, 6 building, 7 and 18 noise). Required; with the option "building-class": "any" the class
  // of a point that has none is 0 or 1.
  const uint8_t *classification;
  // Optional: numbers of the returns, from 1.
  const uint8_t *return_number;
  // Optional: 1 synthetic, 4 withheld, 8 overlap of two strips; sums of these. Synthetic and withheld points are not used.
  const uint8_t *flags;
  // Optional: the building that a point belongs to, as a number; negative for none. The number is the id of a
  // footprint as text, so 17 is "17". Not together with building_name.
  const int64_t *building_number;
  // Optional: the same as UTF-8 text; NULL or "" for none.
  const char *const *building_name;
} gable_chunk;

// Takes the model line by line: first a CityJSON object without buildings (its "transform" is that of all that
// follow), then one CityJSONFeature per building, in the order of the footprints, then one per piece of the terrain if the job
// asks for it. Together they are a CityJSONSeq. The line has no line end, ends with a zero after its length, and is yours
// until you return.
//
// Return 0 to go on, anything else to stop the run.
typedef int (*gable_line_callback)(const char *line, size_t length, void *user_data);

// Is told how far the run is: done of total in the unit of the stage. It is called some twenty times a second, also
// while nothing changes.
//
// Return 0 to go on, anything else to stop the run: buildings under way are completed and what is done is written.
typedef int (*gable_progress_callback)(enum gable_stage stage,
                                       uint64_t done,
                                       uint64_t total,
                                       void *user_data);

// An option of the stage `writers.lod2` of `gable pipeline`.
typedef struct gable_option {
  // Its name, such as "building_class".
  const char *name;
  // What it does and what it accepts: one line without a full stop.
  const char *help;
  // Its default as text; NULL when it has none.
  const char *default_value;
  // Not 0 when it takes several values: an array of texts, or one text with commas.
  int is_list;
  // Not 0 when the stage cannot do without it.
  int is_required;
} gable_option;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The version of the library, such as "0.1.0". The text is never freed.
const char *gable_version(void);

// Creates a job.
//
// options is a JSON object whose members are the options of `gable reconstruct`, without the dashes in front:
// {"footprints": "buildings.gpkg", "output": "city.city.json", "overwrite": true, "building-class": "6"}. NULL or "" is {}.
// Nothing is required: without "footprints" the points are one building, or one for each id that they name; without
// "output" no file is written and the callback of gable_run gets the model. "tiles" names LAS, LAZ or COPC files to be read
// besides the points that are pushed, or instead of any.
//
// crs is the CRS of the points: a code such as "EPSG:7415", WKT or PROJJSON. NULL or "" if tiles name it.
//
// *job becomes a job in any case (NULL only when job itself is NULL or memory has run out), which must be freed with
// gable_free. When the status is not GABLE_STATUS_OK, gable_error(*job) says why, and the job can do nothing else.
enum gable_status gable_create(const char *options,
                               const char *crs,
                               struct gable_job **job);

// Takes a chunk of points. Chunks may have any size, also none, and any order. The points wait in a nameless temporary
// file (32 bytes a point, in the folder that TMPDIR names, or /tmp), not in memory.
//
// Points that name a building are given to the footprint of that id wherever they lie; without footprints each
// building that is named is reconstructed on its own, and points that name none belong to none. The class counts all the
// same: points of a building have one of the building classes, and ground points around it help to find its height.
//
// When the status is not GABLE_STATUS_OK none of the chunk's points were taken, unless the temporary file could not be
// written. Coordinates that are not finite numbers are an error.
enum gable_status gable_push(struct gable_job *job,
                             const struct gable_chunk *chunk);

// Says that a rectangle was scanned (in the units of the CRS), although points of it may have been left out, so that
// footprints in it do not count as incomplete. May be called several times; without it the extent of the points is taken.
enum gable_status gable_cover(struct gable_job *job,
                              double min_x,
                              double min_y,
                              double max_x,
                              double max_y);

// Reconstructs the buildings. Returns when it is done; a job runs once.
//
// on_line gets the model line by line, and on_progress is told how far it is; either may be NULL. Both are called on the
// thread that called gable_run, one at a time, with user_data. They must return (no exception, no longjmp) and may use other
// jobs but not this one. Without on_line the options must name an output; with both, the model goes to both.
enum gable_status gable_run(struct gable_job *job,
                            gable_line_callback on_line,
                            gable_progress_callback on_progress,
                            void *user_data);

// Why the last call on the job failed, in one line: what was found where, what was expected, and what to do; or what the
// model lacks when a run was GABLE_STATUS_INCOMPLETE or GABLE_STATUS_EMPTY. "" after all other calls. Valid until the next call on the job.
const char *gable_error(const struct gable_job *job);

// The report of the run as JSON (schemas/report.schema.json): counts, quality, warnings, and what became of each
// building. NULL before the run, and when it failed. Valid until the job is freed.
const char *gable_report(const struct gable_job *job);

// A part of the report by its JSON Pointer (RFC 6901), such as "/counts" or "/warnings/0": a text without its quotes, all
// else as JSON. NULL when there is none, such as behind the last warning. Valid until this is called again for the job.
const char *gable_report_part(const struct gable_job *job,
                              const char *pointer);

// Frees a job and its points; NULL is fine. A job may be freed once, and neither it nor its texts may be used after that.
// A job that is running is not freed: the status is GABLE_STATUS_BUSY.
enum gable_status gable_free(struct gable_job *job);

// The options of the stage `writers.lod2` of `gable pipeline`, for a program with pipelines of its own; those that all
// stages have, such as "where", are not among them. *count becomes their number. They are never freed.
const struct gable_option *gable_writer_options(size_t *count);

// As gable_create, for a stage of another program's pipeline: options has the members that gable_writer_options tells, with
// the same checks and the same words as in `gable pipeline`. "filename" is required, and "footprints" or "no_footprint". A
// file of that name is refused at once unless "overwrite" says otherwise. "crs" goes before the crs of the points. The points
// that are pushed wait beside the file that is to be written.
enum gable_status gable_create_writer(const char *options,
                                      const char *crs,
                                      struct gable_job **job);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* GABLE_H */
