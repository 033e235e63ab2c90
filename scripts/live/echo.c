// The least that any gateway has to do: reads one frame, writes one frame.
//
//   echo INTERFACE QUESTION ANSWER all|only      (identifiers in hexadecimal)
//
// `all` reads every frame and answers those of the identifier QUESTION, as a gateway must that uses
// the others, too; with `only` the kernel gives it no other.
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static void must(int ok, const char *what) {
    if (!ok) {
        perror(what);
        exit(1);
    }
}

int main(int count, char **words) {
    if (count != 5) {
        fprintf(stderr, "usage: echo INTERFACE QUESTION ANSWER all|only\n");
        return 2;
    }
    canid_t question = strtoul(words[2], NULL, 16), answer = strtoul(words[3], NULL, 16);
    int raw = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    must(raw >= 0, "socket");
    if (strcmp(words[4], "only") == 0) {
        struct can_filter filter = {question, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
        must(setsockopt(raw, SOL_CAN_RAW, CAN_RAW_FILTER, &filter, sizeof filter) == 0, "filter");
    }
    struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = if_nametoindex(words[1])};
    must(address.can_ifindex != 0, words[1]);
    must(bind(raw, (struct sockaddr *)&address, sizeof address) == 0, "bind");
    struct can_frame frame;
    while (read(raw, &frame, sizeof frame) == sizeof frame) {
        if (frame.can_id == question) {
            frame.can_id = answer;
            frame.data[4] |= 0x40; // `Raised` of Fd_Warning
            must(write(raw, &frame, sizeof frame) == sizeof frame, "write");
        }
    }
    must(0, "read");
}
