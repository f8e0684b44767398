/* Calls gable from C, as a plug-in of another program would.
 *
 *   interface run OPTIONS CRS POINTS LINES REPORT   pushes the points in chunks, writes the lines and the report
 *   interface named OPTIONS CRS POINTS LINES REPORT the same with the building that each point names
 *   interface cancel OPTIONS CRS POINTS             stops the run from the progress callback
 *   interface abuse                                 calls everything wrongly
 *
 * POINTS holds the number of points (uint64_t) and the columns x, y, z (double), building (int64_t) and class (uint8_t).
 */
#include "gable.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHUNK 10007

#define CHECK(condition)                                                                     \
    do {                                                                                     \
        if (!(condition)) {                                                                  \
            fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition);        \
            exit(1);                                                                         \
        }                                                                                    \
    } while (0)

struct columns {
    uint64_t count;
    double *xyz[3];
    int64_t *building;
    uint8_t *classification;
};

static void *column(FILE *file, uint64_t count, size_t size) {
    void *values = malloc(count * size);
    CHECK(values && fread(values, size, count, file) == count);
    return values;
}

static struct columns load(const char *path) {
    struct columns points;
    FILE *file = fopen(path, "rb");
    CHECK(file && fread(&points.count, sizeof points.count, 1, file) == 1);
    for (int axis = 0; axis < 3; axis++) {
        points.xyz[axis] = column(file, points.count, sizeof(double));
    }
    points.building = column(file, points.count, sizeof(int64_t));
    points.classification = column(file, points.count, 1);
    fclose(file);
    return points;
}

static gable_job *create(const char *options, const char *crs) {
    gable_job *job = NULL;
    if (gable_create(options, crs, &job) != GABLE_STATUS_OK) {
        fprintf(stderr, "%s\n", gable_error(job));
        exit(1);
    }
    return job;
}

static void push(gable_job *job, const struct columns *points, int named) {
    for (uint64_t start = 0; start < points->count; start += CHUNK) {
        uint64_t left = points->count - start;
        gable_chunk chunk = {0};
        chunk.struct_size = sizeof chunk;
        chunk.count = left < CHUNK ? left : CHUNK;
        chunk.x = points->xyz[0] + start;
        chunk.y = points->xyz[1] + start;
        chunk.z = points->xyz[2] + start;
        chunk.classification = points->classification + start;
        chunk.building_number = named ? points->building + start : NULL;
        if (gable_push(job, &chunk) != GABLE_STATUS_OK) {
            fprintf(stderr, "%s\n", gable_error(job));
            exit(1);
        }
    }
}

struct listener {
    gable_job *job;
    FILE *lines;
    int calls;
    int stop;
};

static int on_line(const char *line, size_t length, void *user_data) {
    struct listener *listener = user_data;
    CHECK(strlen(line) == length);
    /* The job is running: it can be neither used nor freed from here. */
    CHECK(gable_cover(listener->job, 0, 0, 1, 1) == GABLE_STATUS_BUSY);
    CHECK(gable_free(listener->job) == GABLE_STATUS_BUSY);
    return fprintf(listener->lines, "%s\n", line) < 0;
}

static int on_progress(gable_stage stage, uint64_t done, uint64_t total, void *user_data) {
    struct listener *listener = user_data;
    CHECK(stage >= GABLE_STAGE_READ && stage <= GABLE_STAGE_TERRAIN && done <= total);
    listener->calls++;
    return listener->stop;
}

static int run(int named, char **arguments) {
    struct columns points = load(arguments[2]);
    gable_job *job = create(arguments[0], arguments[1]);
    push(job, &points, named);
    struct listener listener = {job, fopen(arguments[3], "wb"), 0, 0};
    CHECK(listener.lines && gable_report(job) == NULL);
    gable_status status = gable_run(job, on_line, on_progress, &listener);
    fclose(listener.lines);
    if (status == GABLE_STATUS_FAILED) {
        fprintf(stderr, "%s\n", gable_error(job));
        return 1;
    }
    CHECK(listener.calls >= 4 && (status == GABLE_STATUS_OK) == (strcmp(gable_error(job), "") == 0));
    const char *part = gable_report_part(job, "/exit_code");
    CHECK(part && part[0] == (status == GABLE_STATUS_OK ? '0' : status == GABLE_STATUS_EMPTY ? '1' : '2') && !part[1]);
    CHECK(gable_report_part(job, "/warnings/4096") == NULL && gable_report_part(job, "\xff") == NULL);
    FILE *report = fopen(arguments[4], "wb");
    CHECK(report && fputs(gable_report(job), report) >= 0);
    fclose(report);
    /* A job runs once. */
    CHECK(gable_run(job, NULL, NULL, NULL) == GABLE_STATUS_FAILED);
    CHECK(strstr(gable_error(job), "has run") && gable_report(job) != NULL);
    CHECK(gable_free(job) == GABLE_STATUS_OK);
    printf("%d\n", status);
    return 0;
}

static int cancel(char **arguments) {
    struct columns points = load(arguments[2]);
    gable_job *job = create(arguments[0], arguments[1]);
    push(job, &points, 0);
    struct listener listener = {job, NULL, 0, 1};
    CHECK(gable_run(job, NULL, on_progress, &listener) == GABLE_STATUS_CANCELLED);
    CHECK(gable_free(job) == GABLE_STATUS_OK);
    return 0;
}

/* The call must fail and the error must hold the text. */
static void refused(gable_job *job, gable_status status, const char *text) {
    if (status != GABLE_STATUS_FAILED || !strstr(gable_error(job), text)) {
        fprintf(stderr, "status %d, error \"%s\", expected \"%s\"\n", status, gable_error(job), text);
        exit(1);
    }
}

static void refused_options(const char *options, const char *crs, const char *text) {
    gable_job *job = NULL;
    gable_status status = gable_create(options, crs, &job);
    CHECK(job);
    refused(job, status, text);
    /* Nothing more can be done with it, and nothing crashes. */
    gable_chunk chunk = {0};
    CHECK(gable_push(job, &chunk) == GABLE_STATUS_FAILED);
    CHECK(gable_run(job, NULL, NULL, NULL) == GABLE_STATUS_FAILED);
    gable_free(job);
}

/* What another program's pipeline asks for: see gable_create_writer. */
static void writer(void) {
    size_t count = 0;
    int required = 0, lists = 0;
    const gable_option *options = gable_writer_options(&count);
    CHECK(count > 30 && options == gable_writer_options(NULL));
    for (size_t i = 0; i < count; i++) {
        CHECK(options[i].name[0] && options[i].help[0]);
        required += options[i].is_required != 0;
        lists += options[i].is_list != 0;
    }
    CHECK(required == 1 && lists >= 3 && strcmp(options[0].name, "filename") == 0 && options[0].default_value == NULL);
    CHECK(gable_create_writer("{}", NULL, NULL) == GABLE_STATUS_FAILED);
    const char *cases[][3] = {
        {NULL, NULL, "no option `filename`"},
        {"{\"filename\": \"a.city.json\"}", NULL, "neither `footprints` nor `no_footprint`"},
        {"{\"filename\": \"a.city.json\", \"no_footprint\": true, \"lambda\": \"-1\"}", NULL, "from 0 to 1000"},
        {"{\"filename\": \"a.city.json\", \"no_footprint\": true, \"crs\": \"EPSG:0\"}", "EPSG:7415", "EPSG:0"},
        {"{\"filename\": \"a.city.json\", \"no_footprint\": true}", "EPSG:0", "EPSG:0"},
        {"\xff", NULL, "UTF-8"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        gable_job *job = NULL;
        gable_status status = gable_create_writer(cases[i][0], cases[i][1], &job);
        CHECK(job);
        refused(job, status, cases[i][2]);
        CHECK(gable_report_part(job, "/counts") == NULL && gable_report_part(job, NULL) == NULL);
        gable_free(job);
    }
}

static int abuse(void) {
    writer();
    CHECK(strchr(gable_version(), '.'));
    CHECK(gable_create("{}", NULL, NULL) == GABLE_STATUS_FAILED);
    CHECK(gable_push(NULL, NULL) == GABLE_STATUS_FAILED);
    CHECK(gable_cover(NULL, 0, 0, 1, 1) == GABLE_STATUS_FAILED);
    CHECK(gable_run(NULL, NULL, NULL, NULL) == GABLE_STATUS_FAILED);
    CHECK(gable_free(NULL) == GABLE_STATUS_OK && gable_report(NULL) == NULL);
    CHECK(gable_report_part(NULL, "/counts") == NULL);
    CHECK(strstr(gable_error(NULL), "null"));

    refused_options("{\"lambda\": ", NULL, "no JSON object");
    refused_options("[]", NULL, "no JSON object");
    refused_options("{\"lamda\": 1}", NULL, "\"lambda\"");
    refused_options("{\"lambda\": -1}", NULL, "from 0 to 1000");
    refused_options("\xff\xfe", NULL, "UTF-8");
    refused_options("{}", "\xff", "UTF-8");
    refused_options("{}", "EPSG:0", "EPSG:0");

    double values[3] = {0, 1, NAN};
    uint8_t classes[3] = {6, 6, 6};
    const char *names[3] = {"a", NULL, "\xff"};
    int64_t numbers[3] = {1, -1, 2};
    double misaligned[2];
    gable_job *job = create("{}", "EPSG:7415");
    refused(job, gable_push(job, NULL), "null");
    gable_chunk chunk = {0};
    refused(job, gable_push(job, &chunk), "struct_size");
    chunk.struct_size = sizeof chunk;
    CHECK(gable_push(job, &chunk) == GABLE_STATUS_OK && strcmp(gable_error(job), "") == 0);
    chunk.count = 2;
    refused(job, gable_push(job, &chunk), "no column x");
    chunk.x = chunk.y = chunk.z = values;
    refused(job, gable_push(job, &chunk), "no column classification");
    chunk.classification = classes;
    chunk.y = (const double *)((const char *)misaligned + 1);
    chunk.count = 1;
    refused(job, gable_push(job, &chunk), "misaligned");
    chunk.y = values;
    chunk.count = SIZE_MAX;
    refused(job, gable_push(job, &chunk), "fits in memory");
    chunk.count = 3;
    refused(job, gable_push(job, &chunk), "point 2");
    chunk.x = chunk.y = chunk.z = (double[]){0, 1, 2};
    chunk.building_name = names;
    refused(job, gable_push(job, &chunk), "building_name of point 2");
    chunk.building_number = numbers;
    refused(job, gable_push(job, &chunk), "one of them");
    refused(job, gable_cover(job, 1, 0, 0, 1), "covered area");
    refused(job, gable_cover(job, 0, NAN, 0, 1), "covered area");
    /* None of these points was taken. */
    refused(job, gable_run(job, NULL, NULL, NULL), "no points");
    gable_free(job);

    job = create(NULL, "EPSG:7415");
    chunk.building_name = NULL;
    CHECK(gable_push(job, &chunk) == GABLE_STATUS_OK);
    /* There is nowhere for a model to go. */
    refused(job, gable_run(job, NULL, NULL, NULL), "output");
    refused(job, gable_push(job, &chunk), "has run");
    gable_free(job);
    return 0;
}

int main(int count, char **arguments) {
    if (count == 7 && strcmp(arguments[1], "run") == 0) {
        return run(0, arguments + 2);
    }
    if (count == 7 && strcmp(arguments[1], "named") == 0) {
        return run(1, arguments + 2);
    }
    if (count == 5 && strcmp(arguments[1], "cancel") == 0) {
        return cancel(arguments + 2);
    }
    if (count == 2 && strcmp(arguments[1], "abuse") == 0) {
        return abuse();
    }
    fprintf(stderr, "see the head of interface.c\n");
    return 2;
}
