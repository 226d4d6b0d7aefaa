/* Publication through two slots, docs/protocol.md: a second opinion beside publication_check.hpp.
 * Another language and another search, the same memory. Each location keeps all its messages, each
 * message the view it carries; a load takes any message that the reader's view does not exclude.
 * Exact without promises, because the reader never stores.
 *
 * The writer may die before each of its steps. -DRESTART=n: up to n successors, which know of the
 * death by a kernel lock, go on in the same memory and may die like it.
 * -DGENS=n snapshots, -DREADS=n reads of TRIES attempts each.
 * Mutants, each of which must violate an assertion: -DNO_W1 -DNO_W2 -DNO_R4 -DONE_SLOT
 * -DCHECK_LATEST -DW1_RELAXED -DW4_W5_RELAXED -DW5_RELAXED -DR1_RELAXED -DR1_R2_RELAXED
 * -DR2_RELAXED -DR5_RELAXED. Harmless: -DW4_RELAXED. -DSNAPSHOTS_ONLY asserts nothing of progress.
 * tests/model/check_spin knows what to expect of each.
 */
#ifndef GENS
#define GENS 4
#endif
#ifndef TRIES
#define TRIES 2
#endif
#ifndef READS
#define READS 2
#endif

#define LATEST 0
#ifdef ONE_SLOT
#define SLOT(g) 0
#else
#define SLOT(g) ((g) & 1)
#endif
#define SEQ(s) (1 + (s))
#define WORD(s, w) (3 + 2 * (s) + (w))
#define LOCATIONS 7
#define MESSAGES 12  /* of one location */

#define RELAXED 0
#define ORDERED 1    /* release or acquire */
#ifdef W1_RELAXED
#define W1_ORDER RELAXED
#else
#define W1_ORDER ORDERED
#endif
#if defined(W4_RELAXED) || defined(W4_W5_RELAXED)
#define W4_ORDER RELAXED
#else
#define W4_ORDER ORDERED
#endif
#if defined(W5_RELAXED) || defined(W4_W5_RELAXED)
#define W5_ORDER RELAXED
#else
#define W5_ORDER ORDERED
#endif
#if defined(R1_RELAXED) || defined(R1_R2_RELAXED)
#define R1_ORDER RELAXED
#else
#define R1_ORDER ORDERED
#endif
#if defined(R2_RELAXED) || defined(R1_R2_RELAXED)
#define R2_ORDER RELAXED
#else
#define R2_ORDER ORDERED
#endif
#ifdef R5_RELAXED
#define R5_ORDER RELAXED
#else
#define R5_ORDER ORDERED
#endif

typedef Location { byte count; byte value[MESSAGES]; byte view[84] }  /* MESSAGES * LOCATIONS */
Location memory[LOCATIONS];
#define NEWEST(l) (memory[l].count - 1)
#define NEWEST_VALUE(l) memory[l].value[NEWEST(l)]

/* One publication of one writer: what each word of its payload holds. */
#define PUBLICATION(g, writer) ((g) * 4 + (writer))

byte released[LOCATIONS];  /* the writer's view at its last release fence */

inline store(l, v, order) {
  atomic {
    assert(memory[l].count < MESSAGES);
    memory[l].value[memory[l].count] = v;
    k = 0;
    do
    :: k < LOCATIONS ->
       memory[l].view[memory[l].count * LOCATIONS + k] =
         (k == l -> memory[l].count : (order == ORDERED -> NEWEST(k) : released[k]));
       k++
    :: else -> break
    od;
    memory[l].count++;
    k = 0
  }
}

inline release_fence() {
  atomic {
    k = 0;
    do
    :: k < LOCATIONS -> released[k] = NEWEST(k); k++
    :: else -> break
    od;
    k = 0
  }
}

/* What a reader finds that sees the newest messages only, as it may once the writer is dead. */
inline check_quiescent() {
  atomic {
    g = NEWEST_VALUE(LATEST);
    s = SLOT(g);
    assert(g == 0 || NEWEST_VALUE(SEQ(s)) == 2 * g);
    assert(g == 0 || NEWEST_VALUE(WORD(s, 0)) >> 2 == g);
    assert(g == 0 || NEWEST_VALUE(WORD(s, 0)) == NEWEST_VALUE(WORD(s, 1)));
    g = 0;
    s = 0
  }
}

/* A step, or death before it. */
#define STEP(x) if :: x :: goto death fi

proctype Writer() {
  byte g, s, k, writer = 0;
start:
  g = NEWEST_VALUE(LATEST) + 1;
  do
  :: g > GENS -> break
  :: else ->
     s = SLOT(g);
#ifndef NO_W1
     STEP(store(SEQ(s), 2 * g - 1, W1_ORDER));                      /* W1 */
#endif
#ifndef NO_W2
     release_fence();                                               /* W2 */
#endif
     STEP(store(WORD(s, 0), PUBLICATION(g, writer), RELAXED));      /* W3 */
     STEP(store(WORD(s, 1), PUBLICATION(g, writer), RELAXED));
     STEP(store(SEQ(s), 2 * g, W4_ORDER));                          /* W4 */
     STEP(store(LATEST, g, W5_ORDER));                              /* W5 */
     g++
  od;
  goto end;
death:
  check_quiescent();
#ifdef RESTART
  if
  :: writer < RESTART ->
     atomic {
       writer++;
       k = 0;
       do
       :: k < LOCATIONS -> released[k] = 0; k++
       :: else -> break
       od;
       k = 0;
       goto start
     }
  :: else
  fi;
#endif
end:
  check_quiescent()
}

proctype Reader() {
  byte current[LOCATIONS];  /* no load is answered by an older message */
  byte pending[LOCATIONS];  /* what an acquire fence would make of it */
  byte g, s, q, word0, word1, publication, tries, reads, k, m;
  byte accepted, before;    /* snapshots: last accepted, of the attempt before */
  bool ok;

#define LOAD(l, target, order) atomic { \
    m = current[l]; \
    do :: m < NEWEST(l) -> m++ :: break od; \
    target = memory[l].value[m]; \
    current[l] = m; \
    k = 0; \
    do \
    :: k < LOCATIONS -> \
       if :: memory[l].view[m * LOCATIONS + k] > pending[k] -> \
             pending[k] = memory[l].view[m * LOCATIONS + k] :: else fi; \
       if :: order == ORDERED && memory[l].view[m * LOCATIONS + k] > current[k] -> \
             current[k] = memory[l].view[m * LOCATIONS + k] :: else fi; \
       k++ \
    :: else -> break \
    od; \
    k = 0; m = 0 }
#define ACQUIRE_FENCE atomic { \
    k = 0; do :: k < LOCATIONS -> current[k] = pending[k]; k++ :: else -> break od; k = 0 }
#ifdef CHECK_LATEST
#define LOAD_SEQUENCE(order) LOAD(LATEST, q, order); q = 2 * q
#else
#define LOAD_SEQUENCE(order) LOAD(SEQ(s), q, order)
#endif

  do
  :: reads < READS ->
     do
     :: tries < TRIES && !ok ->
        LOAD(LATEST, g, R1_ORDER);                                  /* R1 */
        if
        :: g == 0 -> break
        :: else
        fi;
#ifndef SNAPSHOTS_ONLY
        assert(g > before);          /* the attempt before failed for a later publication */
#endif
        s = SLOT(g);
        LOAD_SEQUENCE(R2_ORDER);                                    /* R2 */
        if
        :: q == 2 * g ->
           LOAD(WORD(s, 0), word0, RELAXED);                        /* R3 */
           LOAD(WORD(s, 1), word1, RELAXED);
#ifndef NO_R4
           ACQUIRE_FENCE;                                           /* R4 */
#endif
           LOAD_SEQUENCE(R5_ORDER);                                 /* R5 */
           ok = (q == 2 * g)
        :: else
        fi;
#ifndef SNAPSHOTS_ONLY
        assert(ok || q >= 2 * (g + 2) - 1);  /* it failed for the next but one */
#endif
        before = g;
        tries++
     :: else -> break
     od;
     if
     :: ok ->
        assert(word0 == word1);      /* whole */
        assert(word0 >> 2 == g);     /* the one reported */
        assert(g >= accepted);       /* never backwards */
        accepted = g
     :: else
     fi;
     atomic {
       g = 0; s = 0; q = 0; word0 = 0; word1 = 0; tries = 0; before = 0; ok = false;
       reads++
     }
  :: else -> break
  od
}

init {
  byte l;
  d_step {
    do
    :: l < LOCATIONS -> memory[l].count = 1; l++
    :: else -> break
    od;
    l = 0
  }
  atomic { run Writer(); run Reader() }
}
