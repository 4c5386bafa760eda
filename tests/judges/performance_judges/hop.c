/* One hop over CycloneDDS: 2 KiB from one process to another that sleeps in a waitset.
 *
 *   hop receive COUNT            prints each one-way time in ns, one a line, then "lost N"
 *   hop publish COUNT PERIOD_US  sends on a fixed schedule once the receiver is matched
 *
 * Reliable, keep last 10, volatile: ROS 2's default. Times are CLOCK_MONOTONIC, which both share.
 * Compiled by performance.py with what idlc makes of hop.idl.
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dds/dds.h"
#include "hop.h"

enum { LATE_MS = 5000, AT_ONCE = 16 };

static uint64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

static dds_entity_t checked(dds_entity_t result, const char *what) {
  if (result < 0) {
    fprintf(stderr, "%s: %s\n", what, dds_strretcode(-result));
    exit(1);
  }
  return result;
}

static int publish(dds_entity_t participant, dds_entity_t topic, const dds_qos_t *qos, uint32_t count, long period_us) {
  dds_entity_t writer = checked(dds_create_writer(participant, topic, qos, NULL), "writer");
  dds_publication_matched_status_t matched = {0};
  while (matched.current_count == 0) {
    checked(dds_get_publication_matched_status(writer, &matched), "matched");
    dds_sleepfor(DDS_MSECS(10));
  }
  static performance_Hop message;
  memset(&message, 0, sizeof message);
  struct timespec due;
  clock_gettime(CLOCK_MONOTONIC, &due);
  due.tv_sec += 1;
  for (uint32_t sequence = 1; sequence <= count; sequence++) {
    due.tv_nsec += period_us * 1000;
    due.tv_sec += due.tv_nsec / 1000000000;
    due.tv_nsec %= 1000000000;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, NULL) != 0) {
    }
    message.number = sequence;
    message.sent_ns = now_ns();
    checked(dds_write(writer, &message), "write");
  }
  checked(dds_wait_for_acks(writer, DDS_SECS(5)), "acknowledgement");
  return 0;
}

static int receive(dds_entity_t participant, dds_entity_t topic, const dds_qos_t *qos, uint32_t count) {
  dds_entity_t reader = checked(dds_create_reader(participant, topic, qos, NULL), "reader");
  dds_entity_t waitset = checked(dds_create_waitset(participant), "waitset");
  dds_entity_t ready = checked(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
  checked(dds_waitset_attach(waitset, ready, 0), "attach");
  uint64_t *latency_ns = malloc(count * sizeof *latency_ns);
  void *samples[AT_ONCE] = {NULL};
  dds_sample_info_t infos[AT_ONCE];
  uint32_t received = 0, newest = 0;
  while (newest < count) {
    int triggered = dds_waitset_wait(waitset, NULL, 0, DDS_MSECS(newest == 0 ? 20 * LATE_MS : LATE_MS));
    if (checked(triggered, "wait") == 0) {
      fprintf(stderr, "nothing came for seconds; %u of %u received\n", received, count);
      return 1;
    }
    int taken = checked(dds_take(reader, samples, infos, AT_ONCE, AT_ONCE), "take");
    uint64_t at_ns = now_ns();
    for (int i = 0; i < taken; i++) {
      if (infos[i].valid_data) {
        const performance_Hop *message = samples[i];
        newest = message->number;
        latency_ns[received++] = at_ns - message->sent_ns;
      }
    }
    dds_return_loan(reader, samples, taken);
  }
  for (uint32_t i = 0; i < received; i++) {
    printf("%llu\n", (unsigned long long)latency_ns[i]);
  }
  printf("lost %u\n", count - received);
  return 0;
}

int main(int argc, char **argv) {
  if (argc < 3) {
    fprintf(stderr, "usage: hop receive COUNT | hop publish COUNT PERIOD_US\n");
    return 2;
  }
  dds_entity_t participant = checked(dds_create_participant(DDS_DOMAIN_DEFAULT, NULL, NULL), "participant");
  dds_entity_t topic =
      checked(dds_create_topic(participant, &performance_Hop_desc, "performance_hop", NULL, NULL), "topic");
  dds_qos_t *qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 10);
  uint32_t count = (uint32_t)strtoul(argv[2], NULL, 10);
  int publishes = strcmp(argv[1], "publish") == 0 && argc > 3;
  int status = publishes ? publish(participant, topic, qos, count, strtol(argv[3], NULL, 10))
                         : receive(participant, topic, qos, count);
  dds_delete_qos(qos);
  dds_delete(participant);
  return status;
}
