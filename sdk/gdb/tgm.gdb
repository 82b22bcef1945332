# SPDX-License-Identifier: MIT
# Makes a module known to gdb when the harness has loaded it, so that "break Program_04" works: make debug.
set confirm off
set breakpoint pending on
handle SIGALRM nostop noprint pass
break tgm_debug_module_loaded
commands
silent
eval "add-symbol-file %s -o %lu", path, offset
continue
end
echo Set breakpoints (break Program_04), then: run\n
