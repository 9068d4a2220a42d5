/* SPDX-License-Identifier: MIT */
#include "tessellation.h"

#include "solver/surface/spans.h"
#include <string.h>

enum {
    STEPS = 16,       /* samples of the speed along a line in one span */
    LINES = 64,       /* lines, at least, by which the distance of rows is measured */
    AROUND = 4,       /* pieces, at least, round a closed direction or between two poles */
    ROWS_COMPARED = 9 /* to find the direction of the rows */
};

/* A row this short, as a share of the surface's size, is a pole. */
static const double pole_length = 1e-9;

/* A triangle of the tessellation may be so flat: next to places that are nearly poles they are. */
static const double least_height = 1e-12;

/* Rows run along parameter `along`, one behind the other across it. */
struct tessellation {
    const struct surface *surface;
    struct surface_cursor cursor;
    struct arena *arena;
    double size;
    size_t most;
    int along;
    struct row *rows;
    size_t row_count;
    int *pieces; /* of each row and span along it */
    struct vec3 *points;
    double (*parameters)[2];
    size_t point_count;
    int32_t (*triangles)[3];
    size_t triangle_count;
};

struct row {
    double across; /* its parameter */
    size_t first;  /* of its points */
    int *pieces;   /* of each span; points are one more than their sum */
    size_t total;  /* that sum */
    bool pole;     /* it has no points of its own: each triangle there has one */
};

/* Arc length over one span: at[k] from its beginning to the share k / STEPS of it. */
struct ruler {
    double from, width;
    double at[STEPS + 1];
};

static const struct surface_axis *axis_of(const struct tessellation *g, int k) {
    return &g->surface->axis[k];
}

/* r_k, whose length is the speed, at parameters x along and y across. */
static struct vec3 tangent_at(struct tessellation *g, int k, double x, double y, struct vec3 *r) {
    struct surface_jet jet;
    double uv[2];
    uv[g->along] = x;
    uv[1 - g->along] = y;
    surface_jet_at(g->surface, &g->cursor, uv[0], uv[1], &jet);
    *r = jet.r;
    return k == 0 ? jet.u : jet.v;
}

/* The arc length over a span of direction k, by the rule of the middle points: of the row at y, or
 * across the rows, where they are furthest apart. */
static struct ruler measure_span(struct tessellation *g, int k, int span, double y) {
    const struct surface_axis *axis = axis_of(g, k);
    struct ruler ruler = {.from = axis->breaks[span],
                          .width = axis->breaks[span + 1] - axis->breaks[span]};
    const struct surface_axis *row = axis_of(g, g->along);
    struct vec3 r;
    int lines = row->span_count < LINES ? (LINES - 1) / row->span_count + 1 : 1;
    for (int step = 0; step < STEPS; step++) {
        double middle = ruler.from + ruler.width * (step + 0.5) / STEPS;
        double speed = k == g->along ? vec3_norm(tangent_at(g, k, middle, y, &r)) : 0;
        /* the fastest that any of many lines goes across the rows */
        for (int n = 0; k != g->along && n < row->span_count * lines; n++) {
            const double *breaks = &row->breaks[n / lines];
            double x = breaks[0] + (breaks[1] - breaks[0]) * (n % lines + 0.5) / lines;
            speed = fmax(speed, vec3_norm(tangent_at(g, k, x, middle, &r)));
        }
        ruler.at[step + 1] = ruler.at[step] + speed * ruler.width / STEPS;
    }
    return ruler;
}

static double row_length(struct tessellation *g, double y) {
    double sum = 0;
    for (int span = 0; span < axis_of(g, g->along)->span_count; span++)
        sum += measure_span(g, g->along, span, y).at[STEPS];
    return sum;
}

/* The parameter at a share of the ruler's length, linear within its steps. */
static double parameter_at_share(const struct ruler *ruler, double share) {
    double length = share * ruler->at[STEPS];
    int k = 0;
    while (k < STEPS - 1 && ruler->at[k + 1] < length)
        k++;
    double step = ruler->at[k + 1] - ruler->at[k];
    double part = step > 0 ? (length - ruler->at[k]) / step : share * STEPS - k;
    return ruler->from + ruler->width * (k + fmin(fmax(part, 0), 1)) / STEPS;
}

/* Pieces of about `size`, at least `least`; more than `most` count as so many and one. */
static size_t pieces_of(const struct tessellation *g, double length, size_t least) {
    double wanted = length / g->size;
    size_t pieces = wanted < (double)g->most ? (size_t)ceil(wanted * (1 - 1e-9)) : g->most + 1;
    return pieces > least ? pieces : least;
}

/* ---- where the points are ---- */

/* How much the lengths of lines along direction k differ: the shortest over the longest. */
static double evenness(struct tessellation *g, int k) {
    double shortest = HUGE_VAL, longest = 0;
    g->along = k;
    const struct surface_axis *across = axis_of(g, 1 - k);
    double low = surface_axis_lower(across), width = surface_axis_upper(across) - low;
    for (int row = 0; row < ROWS_COMPARED; row++) {
        double length = row_length(g, low + width * row / (ROWS_COMPARED - 1));
        shortest = fmin(shortest, length);
        longest = fmax(longest, length);
    }
    return shortest / longest;
}

/* Counts the rows, or with g->rows sets their parameters. */
static enum status place_rows(struct tessellation *g) {
    int across = 1 - g->along;
    const struct surface_axis *axis = axis_of(g, across);
    bool many = axis->closed || axis->pole[0] || axis->pole[1];
    size_t least = many ? (size_t)((AROUND - 1) / axis->span_count + 1) : 1;
    g->row_count = 0;
    for (int span = 0; span < axis->span_count; span++) {
        struct ruler ruler = measure_span(g, across, span, 0);
        size_t pieces = pieces_of(g, ruler.at[STEPS], least);
        if (g->row_count + pieces > g->most)
            return STATUS_TOO_MANY_NODES;
        for (size_t k = 0; k < pieces && g->rows; k++)
            g->rows[g->row_count + k].across =
                parameter_at_share(&ruler, (double)k / (double)pieces);
        g->row_count += pieces;
    }
    if (g->rows)
        g->rows[g->row_count].across = surface_axis_upper(axis);
    g->row_count++;
    return STATUS_OK;
}

/* Cuts all rows; a closed surface's last one as the first, of which it is the copy. */
static enum status cut_rows(struct tessellation *g) {
    const struct surface_axis *axis = axis_of(g, g->along);
    size_t spans = (size_t)axis->span_count, triangles = 0;
    size_t least = axis->closed ? (AROUND - 1) / spans + 1 : 1;
    bool closed = axis_of(g, 1 - g->along)->closed;
    for (size_t k = 0; k < g->row_count; k++) {
        struct row *row = &g->rows[k];
        row->pieces = g->pieces + k * spans;
        if (closed && k + 1 == g->row_count) {
            memcpy(row->pieces, g->rows[0].pieces, spans * sizeof *row->pieces);
            row->total = g->rows[0].total;
            row->pole = g->rows[0].pole;
        } else {
            row->pole = row_length(g, row->across) <= pole_length * g->surface->size;
            for (size_t span = 0; span < spans && !row->pole; span++) {
                struct ruler ruler = measure_span(g, g->along, (int)span, row->across);
                size_t pieces = pieces_of(g, ruler.at[STEPS], least);
                row->pieces[span] = (int)pieces;
                row->total += pieces;
            }
        }
        triangles += row->total * (k == 0 || k + 1 == g->row_count ? 1 : 2);
        if (triangles > g->most)
            return STATUS_TOO_MANY_NODES;
    }
    g->triangle_count = triangles;
    return STATUS_OK;
}

static void add_row_point(struct tessellation *g, double x, double y, struct vec3 r) {
    g->points[g->point_count] = r;
    g->parameters[g->point_count][g->along] = x;
    g->parameters[g->point_count][1 - g->along] = y;
    g->point_count++;
}

static void set_row_points(struct tessellation *g, struct row *row) {
    const struct surface_axis *axis = axis_of(g, g->along);
    struct vec3 r;
    row->first = g->point_count;
    if (row->pole)
        return;
    for (int span = 0; span < axis->span_count; span++) {
        struct ruler ruler = measure_span(g, g->along, span, row->across);
        for (int k = 0; k < row->pieces[span]; k++) {
            double x = parameter_at_share(&ruler, (double)k / row->pieces[span]);
            tangent_at(g, 0, x, row->across, &r);
            add_row_point(g, x, row->across, r);
        }
    }
    tangent_at(g, 0, surface_axis_upper(axis), row->across, &r);
    add_row_point(g, surface_axis_upper(axis), row->across,
                  axis->closed ? g->points[row->first] : r);
}

/* ---- triangles ---- */

/* Turned over where rows run along v, so that the normal is along r_u x r_v. */
static void add_strip_triangle(struct tessellation *g, size_t a, size_t b, size_t c) {
    int32_t *corner = g->triangles[g->triangle_count++];
    corner[0] = (int32_t)a;
    corner[1] = (int32_t)(g->along == 0 ? b : c);
    corner[2] = (int32_t)(g->along == 0 ? c : b);
}

/* The triangles between a row and a pole, each with a point of its own there, whose parameter along
 * the row is that of the triangle's middle. */
static void join_pole(struct tessellation *g, const struct row *row, const struct row *pole,
                      bool pole_first) {
    struct vec3 r;
    for (size_t k = row->first; k < row->first + row->total; k++) {
        double x = (g->parameters[k][g->along] + g->parameters[k + 1][g->along]) / 2;
        tangent_at(g, 0, surface_axis_lower(axis_of(g, g->along)), pole->across, &r);
        add_strip_triangle(g, pole_first ? k + 1 : k, pole_first ? k : k + 1, g->point_count);
        add_row_point(g, x, pole->across, r);
    }
}

/* The triangles between two rows, span by span. */
static void join_two_rows(struct tessellation *g, const struct row *p, const struct row *q) {
    if (p->pole != q->pole)
        join_pole(g, p->pole ? q : p, p->pole ? p : q, p->pole);
    if (p->pole || q->pole)
        return;
    const double(*parameters)[2] = (const double(*)[2])g->parameters;
    size_t i = p->first, p_end = i, j = q->first, q_end = j;
    for (int span = 0; span < axis_of(g, g->along)->span_count; span++) {
        p_end += (size_t)p->pieces[span];
        q_end += (size_t)q->pieces[span];
        while (i < p_end || j < q_end) {
            /* The next triangle has its side on row p by the shorter of the two diagonals while
             * both rows have come about as far, else on the row that is behind. */
            bool on_p = j == q_end;
            if (i < p_end && j < q_end) {
                double x[2] = {parameters[i][g->along], parameters[i + 1][g->along]};
                double y[2] = {parameters[j][g->along], parameters[j + 1][g->along]};
                on_p = fabs(x[0] + x[1] - (y[0] + y[1])) > fmin(x[1] - x[0], y[1] - y[0])
                           ? x[0] + x[1] < y[0] + y[1]
                           : vec3_distance(g->points[i + 1], g->points[j]) <=
                                 vec3_distance(g->points[i], g->points[j + 1]);
            }
            add_strip_triangle(g, i, on_p ? i + 1 : j + 1, j);
            i += on_p;
            j += !on_p;
        }
    }
}

/* ---- the whole ---- */

static enum status tessellate_surface(struct tessellation *g) {
    /* Rows may have different numbers of points; so they run where lines differ most in length. */
    double along_u = evenness(g, 0), along_v = evenness(g, 1);
    g->along = along_v < along_u ? 1 : 0;
    enum status status = place_rows(g);
    if (status != STATUS_OK)
        return status;
    size_t spans = (size_t)axis_of(g, g->along)->span_count;
    g->rows = arena_alloc(g->arena, g->row_count, sizeof *g->rows);
    g->pieces = arena_alloc(g->arena, g->row_count * spans, sizeof *g->pieces);
    if (!g->rows || !g->pieces)
        return STATUS_OUT_OF_MEMORY;
    status = place_rows(g);
    if (status == STATUS_OK)
        status = cut_rows(g);
    if (status != STATUS_OK)
        return status;
    /* a point of each row's piece and one more, and one at a pole for each triangle */
    size_t most = 0;
    for (size_t k = 0; k < g->row_count; k++)
        most += 3 * g->rows[k].total + 1;
    g->points = arena_alloc(g->arena, most, sizeof *g->points);
    g->parameters = arena_alloc(g->arena, most, sizeof *g->parameters);
    g->triangles = arena_alloc(g->arena, g->triangle_count, sizeof *g->triangles);
    if (!g->points || !g->parameters || !g->triangles)
        return STATUS_OUT_OF_MEMORY;
    bool closed = axis_of(g, 1 - g->along)->closed;
    struct row *first = &g->rows[0], *last = &g->rows[g->row_count - 1];
    for (struct row *row = first; row <= last - closed; row++)
        set_row_points(g, row);
    if (closed) { /* the first row's points with the parameter of the last */
        last->first = g->point_count;
        for (size_t k = 0; k <= first->total && !last->pole; k++)
            add_row_point(g, g->parameters[first->first + k][g->along], last->across,
                          g->points[first->first + k]);
    }
    g->triangle_count = 0;
    for (struct row *row = first; row < last; row++)
        join_two_rows(g, row, row + 1);
    return STATUS_OK;
}

enum status tessellation_points(const struct surface *surface, double size, size_t most,
                                struct arena *arena, struct tessellation_points *points) {
    struct tessellation g = {.surface = surface, .arena = arena, .size = size, .most = most};
    enum status status = tessellate_surface(&g);
    *points = (struct tessellation_points){g.points, g.parameters, g.point_count};
    return status;
}

enum status mesh_from_surface(const struct surface *surface, double size, size_t most,
                              struct arena *arena, struct mesh **mesh) {
    struct tessellation g = {.surface = surface, .arena = arena, .size = size, .most = most};
    enum status status = tessellate_surface(&g);
    if (status != STATUS_OK)
        return status;
    for (size_t k = 0; k < g.point_count; k++)
        surface_outer(surface, g.parameters[k], g.parameters[k]);
    const struct mesh_source source = {.vertices = g.points,
                                       .vertex_count = g.point_count,
                                       .triangles = (const int32_t(*)[3])g.triangles,
                                       .triangle_count = g.triangle_count,
                                       .least_height = least_height,
                                       .parameters = (const double(*)[2])g.parameters};
    status = mesh_make(&source, arena, mesh, NULL);
    return status == STATUS_INVALID ? STATUS_DEGENERATE_SURFACE : status;
}
