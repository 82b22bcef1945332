/* SPDX-License-Identifier: MIT */
/*
 * The positioning profile of motion.h.
 *
 * In one cycle T the speed goes linearly from v to w, the way is (v + w) / 2 * T. To brake from w with at
 * most b = deceleration * T less in each cycle takes n = ceil(w / b) cycles and the way
 *
 *     S(w) = T * ((n - 1/2) * w - b * n * (n - 1) / 2)
 *
 * which is continuous and grows with w. Each step takes the largest w that the limits allow and for which
 * (v + w) / 2 * T + S(w) still fits into the distance. Then the next step can always take w - b, so the
 * promise is kept to the end; and when the distance was used up exactly, braking with b all the way ends
 * on the target with speed 0.
 */
#include "tgm/motion.h"

/* Braking is planned with a little less than allowed: what rounding takes away on a long way is then
 * made up by the real limit. */
#define PLANNED 0.999999

/* Far from overflow, so that sums and differences of two are numbers, too. */
#define LARGEST  1e300
#define SMALLEST 1e-290 /* products with a cycle are still normal numbers */

static int is_usable(double x)
{
    return x >= -LARGEST && x <= LARGEST;
}

static double size_of(double x)
{
    return x < 0 ? -x : x;
}

void tgm_move_init(struct tgm_move *m, double position, uint32_t cycle_us)
{
    m->position = is_usable(position) ? position : 0;
    m->speed = 0;
    m->target = m->position;
    m->speed_limit = 1;
    m->acceleration = 1;
    m->deceleration = 1;
    m->cycle = cycle_us * 1e-6;
    m->stopping = 0;
}

int tgm_move_set(struct tgm_move *m, double position)
{
    if (!is_usable(position))
        return 0;
    m->position = position;
    m->target = position;
    m->speed = 0;
    m->stopping = 0;
    return 1;
}

int tgm_move_limits(struct tgm_move *m, double speed_limit, double acceleration, double deceleration)
{
    if (!(is_usable(speed_limit) && speed_limit > 0 && is_usable(acceleration) && acceleration > 0 &&
          is_usable(deceleration) && deceleration > 0))
        return 0;
    m->speed_limit = speed_limit;
    m->acceleration = acceleration;
    m->deceleration = deceleration;
    return 1;
}

int tgm_move_to(struct tgm_move *m, double target)
{
    if (!is_usable(target))
        return 0;
    m->target = target;
    m->stopping = 0;
    return 1;
}

void tgm_move_stop(struct tgm_move *m)
{
    m->stopping = 1;
}

int tgm_move_done(const struct tgm_move *m)
{
    return m->speed == 0 && (m->stopping || m->position == m->target);
}

/*
 * The largest w with w / 2 + S(w) / T <= room, where room = distance / T - v / 2. In units of b and with
 * g = room / b, the left side is n * w - n * (n - 1) / 2, n = ceil(w), and n (n + 1) / 2 at the whole
 * numbers: so n is the smallest whole number with n (n + 1) / 2 >= g.
 */
static double fastest(double room, double b)
{
    if (room <= b)
        return room > 0 ? room : 0;
    const double g = room / b;
    if (g > 1e18) /* more cycles than any machine lives: n (n + 1) / 2 is n^2 / 2, and g might overflow */
        return __builtin_sqrt(2 * room) * __builtin_sqrt(b) - b;
    const double root = 0.5 * (__builtin_sqrt(1 + 8 * g) - 1);
    double n = (double)(uint32_t)root;
    if (n < root)
        n += 1;
    return (g + 0.5 * n * (n - 1)) / n * b;
}

/* The next speed towards a target at distance >= 0; speed is negative when it leads away from it. */
static double next_speed(const struct tgm_move *m, double distance, double speed)
{
    const double brake = m->deceleration * m->cycle;

    if (speed < 0)
        return speed + brake < 0 ? speed + brake : 0;
    const double least = speed > brake ? speed - brake : 0;
    double next = fastest(distance / m->cycle - 0.5 * speed, brake * PLANNED);
    if (next > speed + m->acceleration * m->cycle)
        next = speed + m->acceleration * m->cycle;
    if (next > m->speed_limit)
        next = m->speed_limit;
    return next > least ? next : least;
}

static double brake_step(struct tgm_move *m)
{
    const double brake = m->deceleration * m->cycle;
    const double size = size_of(m->speed) > brake ? size_of(m->speed) - brake : 0;
    const double next = m->speed < 0 ? -size : size;

    m->position += 0.5 * (m->speed + next) * m->cycle;
    m->speed = next;
    m->target = m->position;
    return m->position;
}

double tgm_move_step(struct tgm_move *m)
{
    if (m->cycle <= 0)
        return m->position;
    if (m->stopping)
        return brake_step(m);

    const double direction = m->target < m->position ? -1 : 1;
    const double distance = size_of(m->target - m->position);
    const double speed = direction * m->speed;
    const double next = next_speed(m, distance, speed);
    const double way = 0.5 * (speed + next) * m->cycle;
    /* What lies below this is rounding: of the position itself and of the sums above. */
    const double rounding = 0x1p-47 * (size_of(m->position) + size_of(m->target)) + SMALLEST;

    if (size_of(distance - way) <= rounding && size_of(next) * m->cycle <= 4 * rounding) {
        m->position = m->target;
        m->speed = 0;
    } else {
        m->position += direction * way;
        m->speed = direction * next;
    }
    return m->position;
}
