/* SPDX-License-Identifier: MIT */
/* Inside of the march over the quadrants: their rows, one by one (march_quadrants.c) and several at
 * once (march_wave.c). */
#ifndef SOLVER_MARCH_QUADRANT_H
#define SOLVER_MARCH_QUADRANT_H

#include "march.h"
#include "wave.h"

/* The differences of a row's sequence at its last place: of order 0, 1, .. in u and v. */
struct differences {
    int count; /* of those known */
    double of[WAVE_ORDERS][2];
};

/* Beside cuts: what a place of a row is short of. */
enum quadrant_lack {
    LACKS_ALL = 1,    /* the net has no place there, but further along its row */
    LACKS_BEFORE = 2, /* a yarn to the place before it */
    LACKS_BELOW = 4   /* and to that of the row below */
};

/* A row of a quadrant, places counted from the generator. */
struct quadrant_row {
    struct surface_point
        *at; /* i = 0 .. count - 1; of rows of a wave only the ends of it are kept */
    int32_t count;
    int32_t last;            /* place that has not left the surface; -1: none */
    bool begun;              /* by a wave, which has left the rest of it */
    bool planted, ended;     /* it has a place on the weft generator; there is no more of it */
    bool parted;             /* its next place lies across a cut: it may go on behind that */
    bool waits;              /* in a wave: for one below that does */
    int32_t grown;           /* the places from this one on rest on a yarn that went straight on */
    uint8_t *lacks;          /* of each place, quadrant_lack; NULL where there are no cuts */
    struct differences edge; /* of the edge from the row below to this one, in parameters */
};

/* Numbers of a place, counted from the start away along the arms. */
struct quadrant_place {
    int32_t i, j;
};

struct quadrant {
    _Alignas(64) struct march
        local; /* the march as this quadrant sees it: counts, cursor and view of its own */
    struct march *march; /* = &local */
    enum status status;  /* how it ended */
    int si, sj;
    struct net_node *arm[2]; /* the places on the warp and weft arm, to the first that is none */
    int32_t length;          /* places on the warp arm */
    size_t size;             /* by that on the weft arm */
    int32_t reach[2]; /* of the row below and the one below it: the last place that has not left
                         the surface */
    struct quadrant_row row[WAVE_LANES + 1]; /* those below a wave and of it */
    struct wave *wave;                       /* NULL: row by row */
    const struct wave_kernel *kernel;
    struct net_tile *tile[WAVE_LANES];      /* in which lanes have put their last place */
    struct net_view before[WAVE_LANES + 1]; /* of slots: views of the net before */
    bool in_blocks;                         /* rows are long enough to be marched side by side, and
                                               looked at for folds afterwards */
    int32_t checked;             /* rows before this one have been looked at for overlaps */
    struct quadrant_place *late; /* put into such rows since */
    size_t late_count, late_room;
    size_t kept, alone; /* cells of the last wave that its kernel has solved, or not */
    int resting;        /* waves to be left out, where the last has been of no use */
};

/* Whether the next place of a row is the fourth corner of a cell without a cut in it. */
static inline bool quadrant_has_cell(const struct quadrant_row *below,
                                     const struct quadrant_row *row) {
    if (!row->lacks)
        return true;
    const uint8_t *own = row->lacks + row->count, *under = below->lacks + row->count;
    return !(own[-1] & (LACKS_ALL | LACKS_BELOW)) && !(under[-1] & LACKS_ALL) &&
           !(under[0] & (LACKS_ALL | LACKS_BEFORE));
}

/* The next place of a row rests on that of the row below. */
static inline void quadrant_take_growth(const struct quadrant_row *below,
                                        struct quadrant_row *row) {
    if (row->count >= below->grown && row->count < row->grown)
        row->grown = row->count;
}

/* Ends a row at its next place, which is at `at` or beside that; beside a cut for now. */
void quadrant_stop_row(struct quadrant *q, struct quadrant_row *row, struct vec3 at);

/* Goes on with a row that a cut has stopped (march_behind.c), or ends it. */
enum status quadrant_go_behind(struct quadrant *q, const struct quadrant_row *below,
                               struct quadrant_row *row, int32_t j) STATUS_MUST_USE;

/* The first two steps of a row that lies on `below`, row j counted from the generator: begins it,
 * and puts its next place. */
void quadrant_begin_row(struct quadrant *q, const struct quadrant_row *below,
                        struct quadrant_row *row, int32_t j);
enum status quadrant_grow_node(struct quadrant *q, struct quadrant_row *below,
                               struct quadrant_row *row, int32_t j) STATUS_MUST_USE;

/* Where weft slides: whether the next place of a row rests on places of the row below further ahead
 * than the one after it. */
bool quadrant_rests_far(struct quadrant *q, const struct quadrant_row *below,
                        const struct quadrant_row *row, int32_t j);

/* Makes sure that the row below row j has a place i; `found` is false when the net has none. */
enum status quadrant_reach_below(struct quadrant *q, struct quadrant_row *below, int32_t i,
                                 int32_t j, bool *found) STATUS_MUST_USE;

/* The place (i, j), counted from the start away along the arms; NULL where nothing was put. */
const struct net_node *quadrant_node(struct quadrant *q, int32_t i, int32_t j);

/* Puts the next place of a row; and if no cut parts it from the places that it rests on, D of a
 * cell. */
enum status quadrant_put(struct quadrant *q, struct quadrant_row *row, int32_t j,
                         const struct surface_point *point) STATUS_MUST_USE;
enum status quadrant_place(struct quadrant *q, struct quadrant_row *row, int32_t j,
                           const struct surface_point *point) STATUS_MUST_USE;

/* Takes in the edge from `below` to the place `at` of a row, of which `last` is the one before;
 * NULL: none. On another face of a shell parameters are others: differences begin anew. */
void quadrant_take_edge(struct differences *edge, const struct surface_point *below,
                        const struct surface_point *at, const struct surface_point *last);

/* Rows that are marched before they are looked at for overlaps (quadrant_overlaps.c): those of a
 * row of tiles. The first row of those after j. */
static inline int32_t quadrant_block_end(const struct quadrant *q, int32_t j) {
    int32_t first = q->sj > 0 ? 0 : 1;
    return ((j - first) / NET_TILE + 1) * NET_TILE + first;
}

/* Looks at the rows before row `end` that have not been looked at: where a node lies on another
 * part of the net, it is taken out with all beyond it in its row and beyond its column in the rows
 * above. What comes before it in the order of rows stays. Errors: STATUS_OUT_OF_MEMORY. */
enum status quadrant_check_overlaps(struct quadrant *q, int32_t end) STATUS_MUST_USE;

/* Notes a place that was put into a row that has been looked at. */
enum status quadrant_note_late(struct quadrant *q, int32_t i, int32_t j) STATUS_MUST_USE;

/* Gives a quadrant a wave of at most so many rows (and no more than drape_settings' lanes) if one
 * can go over this surface by this method. */
enum status wave_make(const struct march *march, struct arena *arena, int most,
                      struct quadrant *q) STATUS_MUST_USE;

/* Marches rows j, j + 1, .. on row[0] as far as they go side by side; `count` gets how many have
 * begun. Each is in `row`, and as far as it would be if it alone went there. */
enum status wave_run(struct quadrant *q, int32_t j, int *count) STATUS_MUST_USE;

#endif
