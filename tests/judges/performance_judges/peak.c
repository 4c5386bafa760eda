/* What one thread of this machine can do at most: the bound that the network is held against.
 *
 *   cc -O3 -march=native -ffp-contract=fast -DLANES=16 -o peak16 peak.c && ./peak16
 *
 * Prints JSON: billions of float operations a second in independent fused multiply-adds that never leave the registers, and
 * the time of one float sine with its cosine, by polynomials of the degree that 5e-7 takes, on data in the first cache.
 */
#include <stdint.h>
#include <stdio.h>
#include <time.h>

#ifndef LANES
#define LANES 8
#endif
enum { SUMS = LANES == 16 ? 24 : 12, VECTORS = 256 };

typedef float vector __attribute__((vector_size(4 * LANES)));
typedef int32_t integers __attribute__((vector_size(4 * LANES)));

static double now_s(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static vector all(float value) { return (vector){0} + value; }

static double gflops(long turns) {
  vector sums[SUMS], factor = all(0.999f), summand = all(0.001f);
  for (int i = 0; i < SUMS; i++) {
    sums[i] = all((float)i);
  }
  __asm__ volatile("" : "+x"(factor), "+x"(summand));
  double began_s = now_s();
  for (long turn = 0; turn < turns; turn++) {
#pragma GCC unroll 24
    for (int i = 0; i < SUMS; i++) {
      sums[i] = sums[i] * factor + summand;
    }
  }
  double passed_s = now_s() - began_s;
  vector total = sums[0];
  for (int i = 1; i < SUMS; i++) {
    total += sums[i];
  }
  __asm__ volatile("" : : "x"(total));
  return 2.0 * LANES * SUMS * (double)turns / passed_s * 1e-9;
}

static vector angles[VECTORS], sines[VECTORS], cosines[VECTORS];

static double pair_ns(long turns) {
  for (int i = 0; i < VECTORS; i++) {
    for (int lane = 0; lane < LANES; lane++) {
      angles[i][lane] = 0.013f * (float)(i * LANES + lane) - 20.0f;
    }
  }
  double began_s = now_s();
  for (long turn = 0; turn < turns; turn++) {
    for (int i = 0; i < VECTORS; i++) {
      vector x = angles[i];
      vector shifted = x * 0.318309886f + 12582912.0f;
      vector k = shifted - 12582912.0f;
      vector r = x - k * 3.140625f;
      r = r - k * 9.67502593994140625e-4f;
      r = r - k * 1.50995799097837e-7f;
      vector q = r * r;
      vector sine = r + r * q * (-0.16666657f + q * (8.333016e-3f + q * (-1.9806548e-4f + q * 2.5999032e-6f)));
      vector cosine = 1.0f + q * (-0.4999993f + q * (0.041663982f + q * (-1.3855862e-3f + q * 2.3192828e-5f)));
      integers sign = (integers)shifted << 31;
      sines[i] = (vector)((integers)sine ^ sign);
      cosines[i] = (vector)((integers)cosine ^ sign);
    }
    __asm__ volatile("" : : "r"(sines), "r"(cosines), "r"(angles) : "memory");
  }
  return (now_s() - began_s) * 1e9 / ((double)turns * VECTORS * LANES);
}

int main(void) {
  double best_gflops = 0.0, best_pair_ns = 1e9;
  for (int repeat = 0; repeat < 20; repeat++) {
    double peak = gflops(2000000), pair = pair_ns(2000);
    best_gflops = peak > best_gflops ? peak : best_gflops;
    best_pair_ns = pair < best_pair_ns ? pair : best_pair_ns;
  }
  printf("{\"lanes\": %d, \"gflops\": %.2f, \"sine_cosine_ns\": %.4f}\n", LANES, best_gflops, best_pair_ns);
  return 0;
}
