/* Fast Fourier and cosine transforms of lengths 2^a 3^b 5^c, in the caller's memory.
 *
 * A plan is one relocatable block of twiddle factors, computed by base/detmath: the same bits everywhere.
 * Transforms call no malloc; besides the data they need a `work` array of the same size. Stockham's
 * self-sorting algorithm with radices 4, 2, 3 and 5; about 5 n log2(n) operations. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/team.h"

#define LL_FFT_MAX (1 << 20)
#define LL_FFT_STAGES_MAX 20

typedef struct ll_complex {
    double re, im;
} ll_complex;

typedef enum ll_fft_direction {
    LL_FFT_FORWARD = 1,  /* X[k] = sum over j of x[j] exp(-2 pi i j k / n) */
    LL_FFT_INVERSE = -1, /* with +i, and not divided by n */
} ll_fft_direction;

typedef struct ll_fft {
    int32_t n;
    int32_t stages;
    int32_t radix[LL_FFT_STAGES_MAX];
    ll_complex twiddle[]; /* n: exp(-2 pi i k / n); then n / 2 + 1: exp(-pi i k / (2 n)) for the cosines */
} ll_fft;

bool ll_fft_allowed(int64_t n);        /* 1 to LL_FFT_MAX with no prime factor above 5 */
size_t ll_fft_size(int32_t n);         /* bytes of a plan */
void ll_fft_init(ll_fft *, int32_t n); /* n must be allowed; memory aligned to 8 */

/* `count` transforms of interleaved sequences in place: element j of sequence q is data[j * count + q]. */
void ll_fft_run(const ll_fft *, ll_complex *data, ll_complex *work, int32_t count, ll_fft_direction);

/* `data` has y->n rows of x->n; `team` may be NULL, and changes no bit. */
void ll_fft_run_2d(const ll_fft *x, const ll_fft *y, ll_complex *data, ll_complex *work, ll_fft_direction,
                   ll_team *team);

/* DCT-II, X[k] = 2 sum over j of x[j] cos(pi k (2 j + 1) / (2 n)), and its exact inverse (DCT-III over 2 n):
 * the modes of cell centres between closed walls. Two sequences share one complex transform (Makhoul 1980).
 * `data` holds `pairs` pairs of interleaved sequences: element j of sequence q is data[j * 2 * pairs + q];
 * `work` has as many doubles. */
void ll_dct_run(const ll_fft *, double *data, double *work, int32_t pairs, ll_fft_direction);

/* `data` has y->n rows of x->n, both even; `team` as above. */
void ll_dct_run_2d(const ll_fft *x, const ll_fft *y, double *data, double *work, ll_fft_direction,
                   ll_team *team);
