/* Hints to the compiler that change no result. */
#pragma once

/* The pointer is computed here, once: without this the compiler may compute it again from its parts, by a
 * multiplication, at each use. */
#define LL_KEEP(pointer) __asm__("" : "+r"(pointer))
