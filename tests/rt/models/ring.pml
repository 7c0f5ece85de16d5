/* rt/ring.hpp as spin sees it: a producer that drops what does not fit, a consumer, cells of two
   words, and on each side its own copy of the other's counter. Every value comes out whole, once and
   in order, or is counted as dropped. Every order in which two threads can run is tried; what release
   and acquire forbid appears as the wrong variants in which the order is given up.

   Variants, chosen by -D; each must fail, or the model would prove nothing:
     EARLY_HEAD       a relaxed push: the cell's second word is written after the head has moved
     EARLY_TAIL       a relaxed pop: the tail moves before the cell is copied
     NO_FULL_CHECK    the producer overwrites what has not been read
     OFF_BY_ONE       the producer takes one more cell than there are
     FORGETFUL        drops are not counted
     SHARED_COUNTER   both sides write one count of cells in use, not in one step */

#define N 2
#define LAST 6

typedef Cell { byte first; byte second }
Cell cell[N];
byte head = 0;
byte tail = 0;
byte dropped = 0;
byte used = 0;
bool done = false;

#ifdef OFF_BY_ONE
#define ROOM (N + 1)
#else
#define ROOM N
#endif

proctype Producer() {
  byte mine = 0;
  byte known_tail = 0;
  byte number = 1;
  bool no_room;
  byte count;
  do
  :: number <= LAST ->
#ifdef SHARED_COUNTER
    no_room = (used == N);
#else
    no_room = (mine - known_tail == ROOM);
    if
    :: no_room -> known_tail = tail; no_room = (mine - known_tail == ROOM)
    :: else
    fi;
#endif
#ifdef NO_FULL_CHECK
    no_room = false;
#endif
    if
    :: no_room ->
#ifndef FORGETFUL
      dropped++
#else
      skip
#endif
    :: else ->
      cell[mine % N].first = number;
#ifdef EARLY_HEAD
      head = mine + 1;
      cell[mine % N].second = number;
#else
      cell[mine % N].second = number;
      head = mine + 1;
#endif
#ifdef SHARED_COUNTER
      count = used;
      used = count + 1;
#endif
      mine++
    fi;
    number++
  :: else -> break
  od;
  done = true
}

proctype Consumer() {
  byte mine = 0;
  byte known_head = 0;
  byte before = 0;
  byte received = 0;
  byte first, second, count;
  bool was_done, nothing;
  do
  :: was_done = done;
#ifdef SHARED_COUNTER
    nothing = (used == 0);
#else
    nothing = (mine == known_head);
    if
    :: nothing -> known_head = head; nothing = (mine == known_head)
    :: else
    fi;
#endif
    if
    :: !nothing ->
#ifdef EARLY_TAIL
      tail = mine + 1;
#endif
      first = cell[mine % N].first;
      second = cell[mine % N].second;
#ifndef EARLY_TAIL
      tail = mine + 1;
#endif
#ifdef SHARED_COUNTER
      count = used;
      used = count - 1;
#endif
      mine++;
      assert(first == second);   /* never torn */
      assert(first > before);    /* in order, and once */
      before = first;
      received++
    :: nothing && was_done -> break
    :: else                      /* look again */
    fi
  od;
  assert(received + dropped == LAST)  /* nothing is lost without being counted */
}

init { atomic { run Producer(); run Consumer() } }
