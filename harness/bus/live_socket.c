/* SPDX-License-Identifier: GPL-2.0-or-later */
#define _GNU_SOURCE 1
#include "bus/live_socket.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <linux/if_link.h>
#include <linux/if_packet.h>
#include <linux/rtnetlink.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define ETHER_ECAT    0x88A4
#define ANSWER_BYTES  32768
#define SOCKET_BUFFER (4 << 20) /* room for a master that sends without waiting */

/* What the kernel says of an interface. */
struct link {
    int index;
    unsigned flags; /* IFF_... */
    unsigned short type;
    char kind[16]; /* "veth", "tun"; "" for hardware */
    int bridge;    /* it is a port of that one; 0: of none */
    int peer;      /* other end of a veth; 0: elsewhere or not known */
};

int live_fail(char why[LIVE_WHY], int error, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(why, LIVE_WHY, format, arguments);
    va_end(arguments);
    return error;
}

/* RTA_NEXT() mixes signs. */
static const struct rtattr *next(const struct rtattr *a, int *left)
{
    *left -= (int)RTA_ALIGN(a->rta_len);
    return (const struct rtattr *)((const char *)a + RTA_ALIGN(a->rta_len));
}

static void read_kind(const struct rtattr *info, struct link *link)
{
    int left = (int)RTA_PAYLOAD(info);

    for (const struct rtattr *a = RTA_DATA(info); RTA_OK(a, left); a = next(a, &left)) {
        if (a->rta_type == IFLA_INFO_KIND)
            snprintf(link->kind, sizeof link->kind, "%.*s", (int)RTA_PAYLOAD(a),
                     (const char *)RTA_DATA(a));
    }
}

static int read_int(const struct rtattr *a)
{
    int value = 0;

    if (RTA_PAYLOAD(a) >= sizeof value)
        memcpy(&value, RTA_DATA(a), sizeof value);
    return value;
}

static int read_answer(const struct nlmsghdr *answer, size_t size, struct link *link)
{
    const struct ifinfomsg *message = NLMSG_DATA(answer);
    bool elsewhere = false;

    if (!NLMSG_OK(answer, size))
        return -EBADMSG;
    if (answer->nlmsg_type == NLMSG_ERROR)
        return ((const struct nlmsgerr *)NLMSG_DATA(answer))->error;
    if (answer->nlmsg_type != RTM_NEWLINK || answer->nlmsg_len < NLMSG_LENGTH(sizeof *message))
        return -EBADMSG;
    *link = (struct link){ .index = message->ifi_index,
                           .flags = message->ifi_flags,
                           .type = message->ifi_type };
    int left = (int)IFLA_PAYLOAD(answer);
    for (const struct rtattr *a = IFLA_RTA(message); RTA_OK(a, left); a = next(a, &left)) {
        switch (a->rta_type) {
        case IFLA_LINKINFO:
            read_kind(a, link);
            break;
        case IFLA_MASTER:
            link->bridge = read_int(a);
            break;
        case IFLA_LINK:
            link->peer = read_int(a);
            break;
        case IFLA_LINK_NETNSID:
            elsewhere = true;
            break;
        }
    }
    if (elsewhere || strcmp(link->kind, "veth") != 0)
        link->peer = 0;
    return 0;
}

static int ask(int index, struct link *link)
{
    union {
        struct nlmsghdr header;
        char bytes[ANSWER_BYTES];
    } answer;
    struct {
        struct nlmsghdr header;
        struct ifinfomsg message;
    } question = { .header = { .nlmsg_len = sizeof question,
                               .nlmsg_type = RTM_GETLINK,
                               .nlmsg_flags = NLM_F_REQUEST },
                   .message = { .ifi_index = index } };
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    ssize_t got = -1;
    int error;

    if (fd < 0)
        return -errno;
    if (send(fd, &question, sizeof question, 0) >= 0)
        got = recv(fd, &answer, sizeof answer, 0);
    error = got < 0 ? -errno : read_answer(&answer.header, (size_t)got, link);
    close(fd);
    return error;
}

static int no_such(const char *interface, char why[LIVE_WHY])
{
    struct if_nameindex *all = if_nameindex();
    char names[LIVE_WHY / 2] = "";
    size_t at = 0;

    for (const struct if_nameindex *i = all; i && i->if_name && at < sizeof names; i++)
        at += (size_t)snprintf(names + at, sizeof names - at, "%s %s", at ? "," : ":", i->if_name);
    if (all)
        if_freenameindex(all);
    return live_fail(why, -ENODEV, "no interface '%s'; there are%s", interface,
                     at ? names : " none");
}

static bool virtual_cable(const struct link *link)
{
    return strcmp(link->kind, "veth") == 0 || strcmp(link->kind, "tun") == 0;
}

static int port_of_bridge(const char *interface, const char *which, char why[LIVE_WHY])
{
    return live_fail(
        why, -EPERM,
        "%s%s is a port of a bridge, which may lead to a real network, where simulated "
        "slaves have no place; take it out of the bridge, or say --on-a-real-network",
        which, interface);
}

/* Whether frames sent there can only reach where somebody put a virtual cable. */
static int refuse_real(const char *interface, const struct link *link, char why[LIVE_WHY])
{
    struct link peer;

    if (!virtual_cable(link))
        return live_fail(
            why, -EPERM,
            "%s (%s) may lead to a real network, where simulated slaves have no place; "
            "take one end of a veth pair, or say --on-a-real-network",
            interface, link->kind[0] ? link->kind : "hardware");
    if (link->bridge)
        return port_of_bridge(interface, "", why);
    if (link->peer && ask(link->peer, &peer) == 0 && peer.bridge)
        return port_of_bridge(interface, "the other end of ", why);
    return 0;
}

static int examine(const char *interface, bool real_network, struct link *link, char why[LIVE_WHY])
{
    int index = (int)if_nametoindex(interface);
    int error = index ? ask(index, link) : -ENODEV;

    if (error == -ENODEV)
        return no_such(interface, why);
    if (error)
        return live_fail(why, error, "%s: %s", interface, strerror(-error));
    if (link->flags & IFF_LOOPBACK)
        return live_fail(
            why, -EINVAL,
            "%s has one end: what is sent there comes back to the sender; take one end "
            "of a veth pair",
            interface);
    if (link->type != ARPHRD_ETHER)
        return live_fail(why, -EINVAL, "%s is no Ethernet interface", interface);
    if (!real_network)
        error = refuse_real(interface, link, why);
    if (!error && !(link->flags & IFF_UP))
        return live_fail(why, -ENETDOWN, "%s is down: ip link set %s up", interface, interface);
    return error;
}

/* A socket for one protocol does not see what it sends itself. */
static int attach(int fd, const struct link *link)
{
    const struct sockaddr_ll address = { .sll_family = AF_PACKET,
                                         .sll_protocol = htons(ETHER_ECAT),
                                         .sll_ifindex = link->index };
    const int on = 1, buffer = SOCKET_BUFFER;

    /* These two only make it faster. */
    setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &buffer, sizeof buffer);
    setsockopt(fd, SOL_PACKET, PACKET_QDISC_BYPASS, &on, sizeof on);
    return bind(fd, (const struct sockaddr *)&address, sizeof address) != 0 ? -errno : 0;
}

int live_socket(const char *interface, bool real_network, char why[LIVE_WHY])
{
    struct link link;
    int error = examine(interface, real_network, &link, why);

    if (error)
        return error;
    /* Protocol 0: nothing arrives before it is bound. */
    int fd = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0 && errno == EPERM)
        return live_fail(
            why, -EPERM,
            "raw frames need the right CAP_NET_RAW: run it as root, or in a namespace of "
            "your own (unshare --user --map-root-user --net)");
    error = fd < 0 ? -errno : attach(fd, &link);
    if (!error)
        return fd;
    if (fd >= 0)
        close(fd);
    return live_fail(why, error, "%s: no raw socket: %s", interface, strerror(-error));
}
