/* SPDX-License-Identifier: GPL-2.0-or-later */
/* PLC control: see plc.h. */
#include "host/host_parts.h"

#include <string.h>

#include "host/text16.h"

#if TGM_GENERATION == 5 && TGM_MEMORY_ID == 906
#define COMMAND(main) ((main)->TGM_TgMotionCmd)
#else
#define COMMAND(main) ((main)->TGM_TgMotionKill) /* its name before 5.02 */
#endif

/* Words of the command register; 5.02 has names for them. */
enum {
    COMMAND_EXIT = 0x4C4C494B,
    COMMAND_RESET_BUS = 0x53554252,
    COMMAND_REBOOT = 0x544F4F42,
    COMMAND_RELOAD_INI = 0x494E494C
};

#define AL_CONTROL    0x0120
#define AL_INIT_ACK   0x11
#define PLC_NAME_SIZE (sizeof host->plc.name / sizeof *host->plc.name)

/* The name of the file, without where it lies: registers are the same on every machine. */
void plc_open(struct host *host)
{
    const char *path = host->image->path, *slash = strrchr(path, '/');
    text16_from_utf8(host->plc.name, PLC_NAME_SIZE, slash != NULL ? slash + 1 : path);
    memcpy(host->system->Main.PLC_Name, host->plc.name, sizeof host->plc.name);
}

/* There is no other file in here than the one that the host was made for. */
static bool name_is_ours(const struct host *host)
{
    const uint16_t *wanted = host->system->Main.PLC_Name;
    for (size_t i = 0; i < PLC_NAME_SIZE; i++) {
        if (wanted[i] != host->plc.name[i])
            return i == 0 && wanted[0] == 0;
        if (wanted[i] == 0)
            break;
    }
    return true;
}

static uint64_t cycles_of(const struct host *host, uint64_t ns)
{
    const uint64_t cycle = host->config.cycle_us * UINT64_C(1000);
    return (ns + cycle - 1) / cycle;
}

/* First cycle from `first` on that begins at a multiple of PLC_LOAD_STEP_NS. */
static uint64_t aligned(const struct host *host, uint64_t first)
{
    while (first * host->config.cycle_us * UINT64_C(1000) % PLC_LOAD_STEP_NS != 0)
        first++;
    return first;
}

/* Steps 2 to 4. */
static void clear(struct host *host)
{
    for (size_t i = 0; catalogue_memory(host->catalogue, i) != NULL; i++)
        if (strcmp(catalogue_memory(host->catalogue, i)->name, "TGM_Data") == 0)
            memset(host->memory[i], 0, host->memory_bytes[i]);
    for (size_t i = 0; i < host->terminal_count; i++)
        memset(DIO_OUT(host->terminals[i].reg), 0, DIO_WORDS * sizeof(dio_word));
    for (size_t i = 0; i < host->axis_count; i++) {
        host->axes[i].reg->DigitalOut = 0;
        host->axes[i].reg->Mode = host_modes(host)->off;
    }
    host_clear_parts(host);
}

static void stop(struct host *host)
{
    if (sleep_anyone(host)) {
        host->plc.step = PLC_ENDING;
        return;
    }
    host->system->Main.PLC_Ctrl &= ~PLC_CTRL_ERROR_BIT;
    clear(host);
    host->plc.step = PLC_CLEARING;
    host->plc.until = host->cycle + cycles_of(host, PLC_CLEAR_NS);
}

static void stopped(struct host *host)
{
    MAIN *m = &host->system->Main;
    host->plc.step = PLC_STOPPED;
    if (!(m->PLC_Ctrl & PLC_CTRL_LOAD_BIT)) {
        m->PLC_Ctrl &= ~PLC_CTRL_RESET_BIT;
        return;
    }
    if (!name_is_ours(host)) {
        m->PLC_Ctrl &= ~(PLC_CTRL_LOAD_BIT | PLC_CTRL_RESET_BIT);
        m->PLC_Ctrl |= PLC_CTRL_ERROR_BIT;
        return;
    }
    host->plc.step = PLC_LOADING;
    host->plc.until = aligned(host, host->cycle + cycles_of(host, PLC_LOAD_NS));
    host->loop_begin = UINT64_MAX;
    host->exchanged = false;
}

/* Steps 6 to 8. */
static void load(struct host *host)
{
    char why[MACHINE_WHY];
    MAIN *m = &host->system->Main;
    const bool loaded = host->config.kept_module || machine_reload(host->machine, why) == 0;
    host->plc.step = PLC_STOPPED;
    host->loop_begin = host->cycle;
    for (int entry = 0; entry < ENTRY_COUNT; entry++)
        host->evidence->calls[entry].disabled = false;
    host->evidence->loads++;
    const bool started = loaded && plc_begin(host);
    m->PLC_Ctrl &= ~(PLC_CTRL_LOAD_BIT | PLC_CTRL_RESET_BIT);
    if (!started)
        m->PLC_Ctrl |= PLC_CTRL_ERROR_BIT;
}

bool plc_begin(struct host *host)
{
    const bool returned = entries_load(host) && host_call(host, ENTRY_INI);
    /* Program_Ini takes as long as it likes: the schedule goes on when it is over. */
    if (host->real != NULL)
        realtime_start(host->real, host_time_of(host));
    if (!returned || host->evidence->calls[ENTRY_INI].last_value != 1)
        return false;
    host->plc.step = PLC_RUNNING;
    host->plc.run_cycle = host->cycle;
    for (int i = 0; i < 3; i++)
        if (host->due_ns[i] != NEVER_DUE)
            host->due_ns[i] = host_time_of(host);
    return true;
}

/* Every slave to INIT, one after the other; supervision brings them back as at the start. */
static void reset_bus(struct host *host)
{
    struct plc *plc = &host->plc;
    if (!plc->bus_reset || (plc->bus_slave > 0 && !plc->job.done))
        return;
    if (plc->bus_slave == bus_slave_count(host->bus)) {
        plc->bus_reset = false;
        return;
    }
    plc->job = (struct bus_job){ .kind = BUS_REGISTER_WRITE,
                                 .slave = plc->bus_slave++,
                                 .index = AL_CONTROL,
                                 .size = 2,
                                 .data = { AL_INIT_ACK } };
    bus_job_start(host->bus, &plc->job);
}

static void command(struct host *host)
{
    switch (COMMAND(&host->system->Main)) {
    case COMMAND_EXIT:
        host->plc.leave = true;
        break;
    case COMMAND_REBOOT:
    case COMMAND_RELOAD_INI:
        host->plc.anew = true;
        break;
    case COMMAND_RESET_BUS:
        if (host->bus != NULL && !host->plc.bus_reset) {
            host->plc.bus_reset = true;
            host->plc.bus_slave = 0;
        }
        break;
    default:
        return;
    }
    COMMAND(&host->system->Main) = 0;
}

bool plc_cycle(struct host *host)
{
    struct plc *plc = &host->plc;
    const uint32_t asked = host->system->Main.PLC_Ctrl & (PLC_CTRL_LOAD_BIT | PLC_CTRL_RESET_BIT);
    command(host);
    reset_bus(host);
    if ((asked != 0 && (plc->step == PLC_RUNNING || plc->step == PLC_STOPPED)) ||
        plc->step == PLC_ENDING)
        stop(host);
    else if (plc->step == PLC_CLEARING && host->cycle >= plc->until)
        stopped(host);
    else if (plc->step == PLC_LOADING && host->cycle >= plc->until)
        load(host);
    return plc->step != PLC_LOADING;
}

bool plc_calls(const struct host *host)
{
    return host->plc.step == PLC_RUNNING && !(host->system->Main.PLC_Ctrl & PLC_CTRL_PAUSE_BIT);
}

/* As an outside program would. */
void plc_run(struct host *host)
{
    host->system->Main.PLC_Ctrl |= PLC_CTRL_LOAD_BIT;
}

void plc_stop(struct host *host)
{
    host->system->Main.PLC_Ctrl |= PLC_CTRL_RESET_BIT;
}

void plc_pause(struct host *host, bool paused)
{
    if (paused)
        host->system->Main.PLC_Ctrl |= PLC_CTRL_PAUSE_BIT;
    else
        host->system->Main.PLC_Ctrl &= ~PLC_CTRL_PAUSE_BIT;
}

void plc_reset(struct host *host)
{
    COMMAND(&host->system->Main) = COMMAND_REBOOT;
}

enum host_plc plc_state(const struct host *host)
{
    switch (host->plc.step) {
    case PLC_STOPPED:
        return host->system->Main.PLC_Ctrl & PLC_CTRL_ERROR_BIT ? HOST_PLC_ERROR : HOST_PLC_STOPPED;
    case PLC_ENDING:
    case PLC_CLEARING:
    case PLC_LOADING:
        return HOST_PLC_CHANGING;
    case PLC_RUNNING:
        break;
    }
    return plc_calls(host) ? HOST_PLC_RUNNING : HOST_PLC_PAUSED;
}
