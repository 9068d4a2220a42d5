/* SPDX-License-Identifier: MIT */
#include "lcmsim.h"

#include "encoder.h"
#include "solver/vec.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEATURES = 10, POWER_STEPS = 100, LEVELS = 1000 };

static const double PI = 3.14159265358979323846;

/* What is no difference. */
static const double rounding = 1e-9;

/* A variance (of features that are of the order of one) below which elements are alike. */
static const double alike = 1e-12;

/* What the features weigh against each other: the direction as a dyad, whose distance is sqrt 2
 * times the sine of the angle; log k1; log thickness, which goes into flow and volume both; log k2;
 * porosity, of which the fibre volume that fills the rest follows. */
static const double weights[FEATURES] = {1, 1, 1, 1, 1, 1, 1.5, 3, 0.5, 2};

/* A bin while it may still be cut: elements first .. first + count - 1 of the order. */
struct heap_part {
    size_t first, count;
    int axis;
    double mean, spread; /* along the axis of largest spread, area times variance */
};

struct builder {
    const struct lcmsim_source *source;
    struct lcmsim_bins *bins;
    float (*feature)[FEATURES]; /* once the bins are made, differences from them */
    float *area;
    uint32_t *order;
};

/* ---- one element ---- */

/* Twice the area times the normal; half the cross product of the diagonals for a quadrilateral. */
static struct vec3 element_normal(const struct map_fields *fields, size_t element) {
    const int32_t *corner = fields->elements[element];
    const struct vec3 *v = fields->vertices;
    struct vec3 a = v[corner[0]], b = v[corner[1]], c = v[corner[2]];
    if (corner[3] < 0)
        return vec3_cross(vec3_sub(b, a), vec3_sub(c, a));
    return vec3_cross(vec3_sub(c, a), vec3_sub(v[corner[3]], b));
}

static double safe_log(double value) {
    return log(fmax(value, 1e-300));
}

/* ---- cutting ---- */

/* The axis along which the part spreads most. */
static void find_spread(const struct builder *b, struct heap_part *part) {
    double sum[FEATURES] = {0}, squares[FEATURES] = {0}, total = 0;
    const float *origin = b->feature[b->order[part->first]]; /* against cancellation */
    for (size_t n = part->first; n < part->first + part->count; n++) {
        uint32_t element = b->order[n];
        double area = (double)b->area[element];
        total += area;
        for (int k = 0; k < FEATURES; k++) {
            double value = (double)(b->feature[element][k] - origin[k]);
            sum[k] += area * value;
            squares[k] += area * value * value;
        }
    }
    part->spread = 0;
    for (int k = 0; k < FEATURES && total > 0; k++) {
        double mean = sum[k] / total, variance = squares[k] / total - mean * mean;
        if (variance > alike && variance * total > part->spread) {
            part->spread = variance * total;
            part->axis = k;
            part->mean = (double)origin[k] + mean;
        }
    }
}

/* Cuts the widest part at its mean, again and again. How many parts there are then. */
static size_t cut_parts(const struct builder *b, struct heap_part *parts, size_t elements) {
    /* The channel takes the part of the last bin. */
    size_t most = LCMSIM_BINS_MAX - (b->source->fields->channel_permeability > 0), count = 1;
    parts[0] = (struct heap_part){.count = elements};
    find_spread(b, &parts[0]);
    while (count < most) {
        struct heap_part *widest = &parts[0];
        for (size_t k = 1; k < count; k++)
            if (parts[k].spread > widest->spread)
                widest = &parts[k];
        if (widest->spread <= 0)
            break;
        /* What is beyond the mean becomes another part. */
        size_t first = widest->first, low = first, high = first + widest->count;
        struct heap_part *other = &parts[count];
        while (low < high) {
            uint32_t element = b->order[low];
            if ((double)b->feature[element][widest->axis] <= widest->mean) {
                low++;
            } else {
                b->order[low] = b->order[--high];
                b->order[high] = element;
            }
        }
        if (low == first || low == first + widest->count) {
            widest->spread = 0;
            continue;
        }
        *other = (struct heap_part){.first = low, .count = first + widest->count - low};
        widest->count = low - first;
        find_spread(b, widest);
        find_spread(b, other);
        count++;
    }
    return count;
}

/* ---- means ---- */

/* The direction whose dyad is closest to a mean of dyads: its first eigenvector, by powers. */
static struct vec3 principal_direction(const double m[6]) {
    struct vec3 v = m[0] >= m[1] && m[0] >= m[2] ? vec3_make(m[0], m[3], m[5])
                    : m[1] >= m[2]               ? vec3_make(m[3], m[1], m[4])
                                                 : vec3_make(m[5], m[4], m[2]);
    for (int step = 0; step < POWER_STEPS; step++)
        v = vec3_unit(vec3_make(m[0] * v.x + m[3] * v.y + m[5] * v.z,
                                m[3] * v.x + m[1] * v.y + m[4] * v.z,
                                m[5] * v.x + m[4] * v.y + m[2] * v.z));
    return v;
}

static struct lcmsim_inputs mean_of(const struct builder *b, size_t first, size_t count) {
    struct lcmsim_inputs mean = {0};
    double *const means[] = {&mean.thickness, &mean.porosity, &mean.k1, &mean.k2, &mean.k3};
    enum { MEANS = sizeof means / sizeof *means };
    double dyad[6] = {0}, total = 0;
    for (size_t n = first; n < first + count; n++) {
        struct lcmsim_inputs in;
        (void)lcmsim_read(b->source, b->order[n], &in);
        double area = b->area[b->order[n]];
        struct vec3 d = in.direction;
        const double own[6] = {d.x * d.x, d.y * d.y, d.z * d.z, d.x * d.y, d.y * d.z, d.x * d.z};
        total += area;
        const double values[MEANS] = {in.thickness, in.porosity, in.k1, in.k2, in.k3};
        for (int k = 0; k < MEANS; k++)
            *means[k] += area * values[k];
        for (int k = 0; k < MAP_RELIEFS; k++)
            mean.relieved[k] += area * in.relieved[k];
        for (int k = 0; k < 6; k++)
            dyad[k] += area * own[k];
    }
    for (int k = 0; k < MEANS; k++)
        *means[k] /= total;
    for (int k = 0; k < MAP_RELIEFS; k++)
        mean.relieved[k] /= total;
    mean.direction = principal_direction(dyad);
    return mean;
}

/* ---- differences ---- */

/* Of an element from its bin; directions as they lie in its plane, 0..90 deg. */
static void note_difference(const struct builder *b, size_t element,
                            const struct lcmsim_inputs *mean,
                            float difference[LCMSIM_DIFFERENCES]) {
    struct lcmsim_inputs in;
    (void)lcmsim_read(b->source, element, &in);
    double angle = 0;
    if (in.k2 < LCMSIM_ISOTROPIC * in.k1) {
        struct vec3 n = vec3_unit(element_normal(b->source->fields, element));
        struct vec3 p = vec3_axpy(-vec3_dot(in.direction, n), n, in.direction);
        struct vec3 q = vec3_axpy(-vec3_dot(mean->direction, n), n, mean->direction);
        angle = vec3_angle(p, q) * 180 / PI;
        angle = fmin(angle, 180 - angle);
    }
    const double values[LCMSIM_DIFFERENCES] = {
        [LCMSIM_DIRECTION] = angle,
        [LCMSIM_K1] = fabs(in.k1 / mean->k1 - 1),
        [LCMSIM_K2] = fabs(in.k2 / mean->k2 - 1),
        [LCMSIM_THICKNESS] = fabs(in.thickness / mean->thickness - 1),
        [LCMSIM_POROSITY] = fabs(in.porosity - mean->porosity),
    };
    for (int k = 0; k < LCMSIM_DIFFERENCES; k++) {
        double value = values[k] > rounding ? values[k] : 0;
        difference[k] = (float)value;
        b->bins->largest[k] = fmax(b->bins->largest[k], value);
    }
}

/* The level that the differences of 95 % of the area of the first `count` of the order keep to. */
static double bound_of_most(const struct builder *b, size_t count, int kind) {
    double area[LEVELS] = {0}, total = 0, sum = 0, largest = b->bins->largest[kind];
    int level = 0;
    for (size_t n = 0; n < count && largest > 0; n++) {
        uint32_t element = b->order[n];
        double share = (double)b->feature[element][kind] / largest;
        level = (int)ceil(LEVELS * share) - 1;
        level = level < 0 ? 0 : level < LEVELS ? level : LEVELS - 1;
        area[level] += (double)b->area[element];
        total += (double)b->area[element];
    }
    for (level = 0; level < LEVELS - 1 && sum + area[level] < 0.95 * total; level++)
        sum += area[level];
    return largest * (level + 1) / LEVELS;
}

/* ---- all ---- */

/* Features and areas; elements with a role beside fabric go to the end of the order, those left out
 * into none. How many are neither. A direction and its opposite are one: they have the same dyad,
 * which counts as much as k1 and k2 differ. */
static size_t order_elements(struct builder *b, size_t *role_elements) {
    const struct map_fields *fields = b->source->fields;
    const uint8_t *roles = fields->roles;
    size_t count = fields->element_count, low = 0, high = count;
    double total = 0;
    for (size_t e = 0; e < count; e++) {
        struct lcmsim_inputs in;
        enum lcmsim_state state = lcmsim_read(b->source, e, &in);
        b->bins->part[e] = 0;
        b->area[e] = 0;
        b->bins->capped += state == LCMSIM_CAPPED;
        b->bins->left_out += state == LCMSIM_LEFT_OUT;
        if (state == LCMSIM_LEFT_OUT)
            continue;
        struct vec3 d = in.direction;
        double ratio = in.k1 > 0 ? in.k2 / in.k1 : 1, s = sqrt(2), w = 1 - ratio;
        const double values[FEATURES] = {
            w * d.x * d.x,     w * d.y * d.y,     w * d.z * d.z,   w * s * d.x * d.y,
            w * s * d.y * d.z, w * s * d.x * d.z, safe_log(in.k1), safe_log(in.thickness),
            safe_log(in.k2),   in.porosity};
        for (int k = 0; k < FEATURES; k++)
            b->feature[e][k] = (float)(weights[k] * values[k]);
        b->area[e] = (float)(vec3_norm(element_normal(fields, e)) / 2);
        total += (double)b->area[e];
        b->order[roles && roles[e] != MAP_FABRIC ? --high : low++] = (uint32_t)e;
    }
    float least = (float)(total > 0 ? 1e-9 * total / (double)count : 1); /* flat ones count, too */
    for (size_t e = 0; e < count; e++)
        b->area[e] = b->area[e] > least ? b->area[e] : least;
    *role_elements = count - high;
    return low;
}

/* The parts of elements that are no plain fabric: the last `count` of the order, each kind moved to
 * the front of what is left. */
static void make_roles(const struct builder *b, size_t count) {
    static const uint8_t parts[MAP_ROLES] = {0, LCMSIM_INLET_PART, LCMSIM_OUTLET_PART,
                                             LCMSIM_CHANNEL_PART};
    const uint8_t *roles = b->source->fields->roles;
    size_t end = b->source->fields->element_count, next = end - count;
    for (int role = MAP_INLET; role < MAP_ROLES; role++) {
        size_t first = next;
        for (size_t n = first; n < end; n++) {
            uint32_t element = b->order[n];
            if (roles[element] != role)
                continue;
            b->bins->part[element] = parts[role];
            b->order[n] = b->order[next];
            b->order[next++] = element;
        }
        b->bins->role_count[role] = next - first;
        if (next > first)
            b->bins->role[role] = mean_of(b, first, next - first);
    }
}

bool lcmsim_make_bins(struct lcmsim_bins *bins, const struct lcmsim_source *source) {
    size_t elements = source->fields->element_count, others;
    struct builder builder = {.source = source,
                              .bins = bins,
                              .feature = malloc(elements * sizeof *builder.feature),
                              .area = malloc(elements * sizeof *builder.area),
                              .order = malloc(elements * sizeof *builder.order)};
    struct heap_part parts[LCMSIM_BINS_MAX];
    *bins = (struct lcmsim_bins){.part = malloc(elements)};
    bool room = builder.feature && builder.area && builder.order && bins->part;
    if (room) {
        size_t inner = order_elements(&builder, &others);
        bins->count = inner > 0 ? cut_parts(&builder, parts, inner) : 0;
        for (size_t k = 0; k < bins->count; k++) {
            bins->bin[k] = mean_of(&builder, parts[k].first, parts[k].count);
            for (size_t n = parts[k].first; n < parts[k].first + parts[k].count; n++) {
                uint32_t element = builder.order[n];
                bins->part[element] = (uint8_t)(LCMSIM_FIRST_PART + k);
                note_difference(&builder, element, &bins->bin[k], builder.feature[element]);
            }
        }
        for (int kind = 0; kind < LCMSIM_DIFFERENCES; kind++)
            bins->most[kind] = bound_of_most(&builder, inner, kind);
        make_roles(&builder, others);
    }
    free(builder.feature);
    free(builder.area);
    free(builder.order);
    return room;
}

void lcmsim_free_bins(struct lcmsim_bins *bins) {
    free(bins->part);
    bins->part = NULL;
}
