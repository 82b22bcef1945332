/* SPDX-License-Identifier: MIT */
/*
 * What C++ code refers to although it allocates nothing and throws nothing: a class with a virtual destructor
 * mentions operator delete, a pure virtual function its trap. Reaching one of them is a defect of the module;
 * the trap instruction makes it a fault that TG Motion and the harness see.
 */
#include <stddef.h>

void operator delete(void *) noexcept
{
    __builtin_trap();
}

void operator delete(void *, size_t) noexcept
{
    __builtin_trap();
}

#ifndef _WIN32
#pragma GCC visibility push(hidden)
#endif
extern "C" void __cxa_pure_virtual(void)
{
    __builtin_trap();
}
