/* SPDX-License-Identifier: GPL-2.0-or-later */
/*
 * races.h - what an interrupt at each instruction would lead to (PREEMPT_TRIED).
 *
 * Before a call of Program_01 to Program_03 that is chosen, it is tried out on the side: the two
 * orders without interrupt first (the function, then one that may interrupt it; and the other way
 * round), then the function interrupted by it before each of its instructions. What the shared
 * memories are afterwards must be what they are after one of the two orders. Everything is put back
 * then, and the run goes on as if nothing had been. No slot goes by meanwhile, so that what differs
 * is the module's own doing.
 *
 * Words of four bytes are compared. The words that only the one function writes, those that only
 * the other does, and those that both do, must each be of one order, but not all of the same: two
 * functions that tell each other something, each by registers of its own, are in order. Of the
 * module's own data only words that both functions write count, when they are of neither order:
 * what is wrong with the rest shows in the shared memories, sooner or later.
 */
#ifndef HARNESS_HOST_RACES_H
#define HARNESS_HOST_RACES_H

#include "host/evidence.h"

#define RACES_PIECE 4096
#define RACES_WORDS (RACES_PIECE / 4)

struct host;

/* A page of something that module code may write. */
struct races_piece {
    char *at;
    size_t size;
    int memory;    /* of the catalogue, by index; -1: the module's own data */
    bool compared; /* put back, but not looked at, otherwise */
};

/* Pieces that follow one another in memory. */
struct races_range {
    uint64_t at;
    size_t size, first;
};

#define RACES_RANGES 32

enum { RACES_OF_ENTRY = 1, RACES_OF_OTHER = 2, RACES_TOUCHED = 4 };

/* The two orders without interrupt, as the memories are after them. */
struct races_order {
    bool judged;     /* both functions return in both orders */
    char *first;     /* after the interrupted function, then the other */
    char *second;    /* after the other, then the interrupted one */
    uint8_t *owners; /* of each word: who writes it, RACES_... */
};

struct races {
    struct races_piece *pieces;
    size_t piece_count;
    struct races_range ranges[RACES_RANGES];
    size_t range_count;
    char *start, *middle; /* memories before the call, and before the instruction */
    struct races_order orders[ENTRY_COUNT];
    uint32_t *touched; /* pieces that anything wrote to */
    size_t touched_count;
    bool *is_touched;

    /* What host services change lies here; nothing else does, while calls are tried. */
    struct host *host_start, *host_middle;
    struct evidence *evidence_start, *evidence_middle;
    uint64_t services;    /* entered when the host was last kept or put back */
    bool is_start;        /* as it was at the start then */
    bool middle_is_start; /* what it was in the middle is what it was at the start */

    bool trying; /* what runs is put back afterwards */
    enum entry entry, by;
    uint64_t instructions, pc; /* the point that is tried */
    bool again;                /* a page was missing: once more */
    uint64_t calls[3], next_cycle[3];
    bool off[3];
    uint64_t drawn;

    struct evidence_race *seeking; /* what attribute() looks for */
    uint64_t tried_calls, tried_points, total;
    unsigned count;
    struct evidence_race found[EVIDENCE_RACES];
};

int races_open(struct host *host, char why[MACHINE_WHY]);
void races_close(struct host *host);
/* Before the call; it is tried out when it is one of those. */
void races_try(struct host *host, enum entry entry);

/* races_state.c: memories and copies of them */
int races_state_open(struct host *host);
void races_state_close(struct races *races);
void races_keep_start(struct host *host);
void races_keep_middle(struct host *host);
void races_back_to_start(struct host *host);
void races_memory_of_start(const struct races *races); /* of the memories only */
void races_back_to_middle(struct host *host);
/* Every piece, after something wrote who knows where: adds it to the touched ones. True when there
 * was a new one. */
bool races_find_touched(struct races *races);
/* The instruction that comes next in the interrupted call: what it is about to write to. */
void races_note_writes(struct host *host);
void races_copy(const struct races *races, char *arena); /* touched pieces as they are */
/* Words that differ from what is in the arena have this owner. */
void races_own(const struct races *races, const char *arena, uint8_t *owners, uint8_t owner);
/* The word at an address: its piece and number in it, if anything wrote to that piece. */
bool races_word_at(const struct races *races, uint64_t address, size_t *piece, size_t *word);

/* races_judge.c: after both functions; and where the other one touched what both use */
void races_compare(struct host *host);
void races_failed(struct host *host, enum entry who, const struct machine_outcome *outcome);

#endif
