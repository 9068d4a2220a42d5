/* SPDX-License-Identifier: MIT */
#include "separation.h"

#include <math.h>

/* Steps of a node's yarns, with a margin; and how far from its sheet a place may be, by those along
 * warp. */
static const double steps = 1.1, sheet = 0.5;

void separation_points(const struct net_window *window, int x, int y,
                       struct separation_points *points) {
    const struct net_tile *tile = window->tile[1][1];
    points->count = 0;
    for (int at = 0; at < SEPARATION_POINTS; at++) {
        int column = x + at % (SEPARATION_SIDE + 1), row = y + at / (SEPARATION_SIDE + 1);
        const struct net_node *node = net_window_find(window, column, row);
        if (!node || node->state != NET_INSIDE)
            continue;
        points->r[points->count] = node->r;
        points->at[points->count][0] = tile->ti * NET_TILE + column;
        points->at[points->count++][1] = tile->tj * NET_TILE + row;
    }
}

static struct vec3 step_at(const struct net_window *window, int x, int y, int dx, int dy) {
    return net_step(net_window_place(window, x - dx, y - dy), net_window_find(window, x, y),
                    net_window_place(window, x + dx, y + dy));
}

/* A node's yarns. */
struct yarns {
    struct vec3 r, a, b, across;
    double dual2, height; /* 1 / |a x b|^2, and the reach along a x b by its length */
};

static struct vec3 dual(const struct yarns *yarns, int k) {
    struct vec3 of = k ? vec3_cross(yarns->across, yarns->a) : vec3_cross(yarns->b, yarns->across);
    return vec3_scale(yarns->dual2, of);
}

static const struct separation_range nothing = {HUGE_VAL, -HUGE_VAL};

static void stretch_range(struct separation_range *range, double value) {
    range->low = value < range->low ? value : range->low;
    range->high = value > range->high ? value : range->high;
}

void separation_frame(const struct net_window *window, int x, int y,
                      struct separation_frame *frame) {
    const struct net_tile *tile = window->tile[1][1];
    struct yarns yarns[SEPARATION_SIDE * SEPARATION_SIDE];
    int32_t number[SEPARATION_SIDE * SEPARATION_SIDE][2];
    int count = 0;
    *frame = (struct separation_frame){.known = true};
    for (int at = 0; at < SEPARATION_SIDE * SEPARATION_SIDE; at++) {
        int column = x + at % SEPARATION_SIDE, row = y + at / SEPARATION_SIDE;
        if (!(tile->bits[NET_BIT_INSIDE][row] >> column & 1))
            continue;
        number[count][0] = tile->ti * NET_TILE + column;
        number[count][1] = tile->tj * NET_TILE + row;
        struct yarns *own = &yarns[count++];
        own->r = net_window_find(window, column, row)->r;
        own->a = step_at(window, column, row, 1, 0);
        own->b = step_at(window, column, row, 0, 1);
        own->across = vec3_cross(own->a, own->b);
        double area2 = vec3_norm2(own->across);
        own->dual2 = 1 / area2;
        own->height = sheet * sqrt(vec3_norm2(own->a) / area2);
        frame->known = frame->known && area2 > 0 && own->dual2 < HUGE_VAL; /* they cross */
    }
    if (!frame->known)
        return;
    /* the means over the nodes */
    struct vec3 up = vec3_make(0, 0, 0), down = up;
    for (int n = 0; n < count; n++) {
        for (int k = 0; k < 2; k++)
            frame->way[k] = vec3_axpy(1.0 / count, dual(&yarns[n], k), frame->way[k]);
        up = vec3_add(up, vec3_add(yarns[n].a, yarns[n].b));
        down = vec3_add(down, vec3_sub(yarns[n].a, yarns[n].b));
    }
    frame->way[2] = vec3_norm2(up) > vec3_norm2(down) ? up : down;
    for (int k = 0; k < SEPARATION_WAYS; k++) {
        frame->cells[k] = nothing;
        for (int n = 0; n < count; n++) { /* by the cells round each node */
            struct vec3 way = frame->way[k];
            double at = vec3_dot(way, yarns[n].r);
            double reach =
                steps * (fabs(vec3_dot(way, yarns[n].a)) + fabs(vec3_dot(way, yarns[n].b)) +
                         yarns[n].height * fabs(vec3_dot(way, yarns[n].across)));
            stretch_range(&frame->cells[k], at - reach);
            stretch_range(&frame->cells[k], at + reach);
        }
    }
    for (int k = 0; k < 2; k++) {
        double spread2 = 0;
        frame->beyond[k] = nothing;
        for (int n = 0; n < count; n++) {
            struct vec3 off = vec3_sub(dual(&yarns[n], k), frame->way[k]);
            spread2 = fmax(spread2, vec3_norm2(off));
            stretch_range(&frame->beyond[k], vec3_dot(frame->way[k], yarns[n].r) - number[n][k]);
        }
        frame->spread[k] = sqrt(spread2);
    }
}

bool separation_holds(const struct separation_frame *frame, const struct separation_points *points,
                      double reach, double least) {
    bool aligned = frame->known;
    for (int k = 0; k < SEPARATION_WAYS && frame->known; k++) {
        struct separation_range along = nothing, beyond = nothing;
        for (int n = 0; n < points->count; n++) {
            double at = vec3_dot(frame->way[k], points->r[n]);
            stretch_range(&along, at);
            if (k < 2)
                stretch_range(&beyond, at - points->at[n][k]);
        }
        if (along.low > frame->cells[k].high || along.high < frame->cells[k].low)
            return true;
        if (k == 2)
            continue;
        struct separation_range numbers = frame->beyond[k];
        double differ = fmax(beyond.high - numbers.low, numbers.high - beyond.low);
        aligned = aligned && differ < least - steps - frame->spread[k] * reach;
    }
    return aligned;
}

bool separation_holds_at(const struct separation_frame *frame, struct vec3 r) {
    for (int k = 0; k < SEPARATION_WAYS && frame->known; k++) {
        double at = vec3_dot(frame->way[k], r);
        if (at > frame->cells[k].high || at < frame->cells[k].low)
            return true;
    }
    return false;
}
