/*
 * Copyright (c) 2018, Arm Limited.
 * SPDX-License-Identifier: MIT
 */
#pragma once
#include "libm.h"

namespace halflight::math {

#define LOG2_TABLE_BITS 6
#define LOG2_POLY_ORDER 7
#define LOG2_POLY1_ORDER 11
extern const struct log2_data {
	double invln2hi;
	double invln2lo;
	double poly1[LOG2_POLY1_ORDER - 1];
	double poly[LOG2_POLY_ORDER - 1];
	struct {
		double invc, logc;
	} tab[1 << LOG2_TABLE_BITS];
	struct {
		double chi, clo;
	} tab2[1 << LOG2_TABLE_BITS];
} log2_table;

} // namespace halflight::math
