/* rt/latest_value.hpp as spin sees it: a writer and a reader, one exchange on each side, a value of
   two words that must never be seen torn, old after new, or not at all. Word by word, every order in
   which two threads can run is tried. Not a model of the memory: what release and acquire forbid
   appears as the wrong variants in which the order is given up.

   Variants, chosen by -D; each must fail, or the model would prove nothing:
     TWO_BUFFERS      a double buffer: the writer fills what the reader may be reading
     EARLY_PUBLISH    a relaxed publish: the second word is written after the exchange
     LATE_READ        a relaxed update: the reader's first word was read before the exchange
     BLIND_EXCHANGE   the reader exchanges without looking whether there is something fresh
     TORN_EXCHANGE    the reader's exchange in two steps, a load and a store */

#define LAST 5
#define FRESH 4
#define INDEX 3

typedef Slot { byte first; byte second }
Slot slot[3];
#ifdef TWO_BUFFERS
byte middle = 0;
#else
byte middle = 1;
#endif
bool written = false;

proctype Writer() {
  byte back = 0;
  byte old;
  byte number = 1;
  do
  :: number <= LAST ->
#ifdef TWO_BUFFERS
    back = 1 - (middle & INDEX);
#endif
#ifdef EARLY_PUBLISH
    slot[back].first = number;
    byte filled = back;
    atomic { old = middle; middle = back | FRESH }
    back = old & INDEX;
    slot[filled].second = number;
#else
    slot[back].first = number;
    slot[back].second = number;
#ifdef TWO_BUFFERS
    middle = back | FRESH;
#else
    atomic { old = middle; middle = back | FRESH }
    back = old & INDEX;
#endif
#endif
    number++
  :: else -> break
  od;
  written = true
}

proctype Reader() {
  byte front = 2;
  byte seen = 0;
  byte old, first, second;
  bool was_written;
  do
  :: seen < LAST ->
    was_written = written;
    if
#ifdef BLIND_EXCHANGE
    :: true ->
#else
    :: (middle & FRESH) != 0 ->
#endif
#ifdef LATE_READ
      first = slot[middle & INDEX].first;
#endif
#ifdef TWO_BUFFERS
      atomic { front = middle & INDEX; middle = front }
#else
#ifdef TORN_EXCHANGE
      old = middle;
      middle = front;
#else
      atomic { old = middle; middle = front }
#endif
      front = old & INDEX;
#endif
#ifndef LATE_READ
      first = slot[front].first;
#endif
      second = slot[front].second;
      assert(first == second);   /* never torn */
      assert(first > seen);      /* fresh means newer than all before */
      seen = first
    :: else ->
      assert(!was_written)       /* nothing fresh, yet the last one was not seen: it is lost */
    fi
  :: else -> break
  od
}

init { atomic { run Writer(); run Reader() } }
