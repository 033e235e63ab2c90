/* What a frame and its answer cost on this machine: the yardstick for figures taken in the test bed.
 *
 *   round_trip vcan0    a frame to a second process, which sends it back with the next identifier
 *   round_trip pair     the same over a pair of datagram sockets, which any machine has
 *
 * Prints the median and the 99th percentile of 2000 round trips in microseconds.
 */
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define ROUNDS 2000
#define REQUEST 0x100
#define ANSWER 0x101

static void give_up(const char *what) {
    perror(what);
    exit(1);
}

/* A socket that takes frames with this identifier only. */
static int open_can(const char *interface, canid_t identifier) {
    struct sockaddr_can address = {.can_family = AF_CAN};
    struct can_filter filter = {identifier, CAN_SFF_MASK};
    int bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    if (bus < 0)
        give_up("socket(PF_CAN)");
    address.can_ifindex = (int)if_nametoindex(interface);
    if (address.can_ifindex == 0)
        give_up(interface);
    if (setsockopt(bus, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter) < 0)
        give_up("CAN_RAW_FILTER");
    if (bind(bus, (struct sockaddr *)&address, sizeof address) < 0)
        give_up("bind");
    return bus;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec * 1e6 + (double)time.tv_nsec / 1e3;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int count, char **words) {
    static double took[ROUNDS];
    struct can_frame frame = {.can_id = REQUEST, .can_dlc = 8};
    int ends[2], i;

    if (count != 2) {
        fprintf(stderr, "usage: round_trip INTERFACE|pair\n");
        return 2;
    }
    if (strcmp(words[1], "pair") == 0) {
        if (socketpair(AF_UNIX, SOCK_DGRAM, 0, ends) < 0)
            give_up("socketpair");
    } else {
        ends[0] = open_can(words[1], ANSWER);
        ends[1] = open_can(words[1], REQUEST);
    }
    switch (fork()) {
    case -1:
        give_up("fork");
        break;
    case 0:
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        while (read(ends[1], &frame, sizeof frame) == sizeof frame) {
            frame.can_id = ANSWER;
            if (write(ends[1], &frame, sizeof frame) != sizeof frame)
                give_up("write");
        }
        give_up("read");
    }
    for (i = 0; i < ROUNDS; i++) {
        double start = now();
        frame.can_id = REQUEST;
        memcpy(frame.data, &i, sizeof i);
        if (write(ends[0], &frame, sizeof frame) != sizeof frame)
            give_up("write");
        if (read(ends[0], &frame, sizeof frame) != sizeof frame)
            give_up("read");
        took[i] = now() - start;
        if (frame.can_id != ANSWER || memcmp(frame.data, &i, sizeof i) != 0) {
            fprintf(stderr, "round trip %d came back as another frame\n", i);
            return 1;
        }
    }
    qsort(took, ROUNDS, sizeof *took, ascending);
    printf("median %.1f us, 99%% within %.1f us\n", took[ROUNDS / 2], took[ROUNDS * 99 / 100]);
    return 0;
}
