/* SPDX-License-Identifier: MIT */
/*
 * What the compiler's arithmetic for Arm calls when an integer is divided by zero. libgcc's own functions ask the
 * C library to raise a signal (Linux), or go on with 0: these stop, as the processor of a PC does.
 */
int __aeabi_idiv0(int value);
long long __aeabi_ldiv0(long long value);

int __aeabi_idiv0(int value)
{
    (void)value;
    __builtin_trap();
}

long long __aeabi_ldiv0(long long value)
{
    (void)value;
    __builtin_trap();
}
