#pragma once
#include <complex.h>  // I

// Macros of Qt and of X11 that are words.
#define slots
#define signals public
#define emit
#define foreach for
#define forever for (;;)
#define None 0L
#define Complex 0
#define Convex 2
#define Nonconvex 1
#define Always 2
#define Above 0
#define Below 1
#define Unsorted 0
#define CursorShape 0
#define KeyPress 2
#define FocusIn 9
#define Expose 12
