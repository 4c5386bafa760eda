/* Ports of cncbf for C and C++: read what the processes of a running stack say, and take the nominal controller's place.
 *
 * Generated from crates/c_ports by `cargo run -p bindings`; do not edit.
 *
 * cargo build --release -p c_ports       makes target/release/libcncbf.a and libcncbf.so
 * cc controller.c -Ibindings/c target/release/libcncbf.a -lpthread -ldl -lm
 *
 * Ownership: what a function fills in belongs to the caller until it is closed, once. Messages and texts are copied.
 * Threads:   a handle is used by one thread at a time, whichever; different handles may be used at the same time.
 * Processes: a child that was forked must use no handle of its parent.
 * Time:      opening and closing take milliseconds and memory. _newest, _wait and _send allocate nothing, but for the first call after
 *            a peer has come or gone.
 * Signals:   the library installs no handler. A program that is told to stop closes its handles and ends.
 *
 * bindings/c/examples/pure_pursuit.c is a whole controller; docs/own_controller.md says what is asked of one. */

#ifndef CNCBF_H
#define CNCBF_H

#include <stddef.h>
#include <stdint.h>
#include "cncbf_messages.h"

/*
 Version of this interface. It grows with every change that a program compiled against an older header would notice.
 */
#define CNCBF_ABI_VERSION 1

/*
 What a function answers.
 */
typedef enum cncbf_result_t {
  /*
   Done.
   */
  CNCBF_RESULT_OK = 0,
  /*
   Nothing has arrived; time is up.
   */
  CNCBF_RESULT_NOTHING = 1,
  /*
   Another living program has the nominal controller's place; time is up.
   */
  CNCBF_RESULT_TAKEN = 2,
  /*
   The call is wrong: a null pointer, an unusable name, an unknown type, another size. cncbf_last_error() says which.
   */
  CNCBF_RESULT_MISUSE = 3,
  /*
   Shared memory failed. cncbf_last_error() says how, and what to do.
   */
  CNCBF_RESULT_FAILED = 4,
} cncbf_result_t;

/*
 Membership of a program in a stack.
 */
typedef struct cncbf_node_t cncbf_node_t;

/*
 The nominal controller's place. Its holder alone writes nominal commands.
 */
typedef struct cncbf_nominal_t cncbf_nominal_t;

/*
 Reads one kind of message.
 */
typedef struct cncbf_reader_t cncbf_reader_t;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Why the last call of this thread that answered CNCBF_RESULT_TAKEN, _MISUSE or _FAILED did so: one line in English; empty before
 the first. Never a null pointer. The text belongs to the library and stands until the next such call of the same thread.
 */
const char *cncbf_last_error(void);

/*
 The version of this interface that the library has; a program compares it with CNCBF_ABI_VERSION, which its header has.
 */
uint32_t cncbf_abi_version(void);

/*
 The stack clock, CLOCK_MONOTONIC, ns: what stamps are made of.
 */
uint64_t cncbf_now_ns(void);

/*
 Joins the stack `instance` ("cncbf" where nobody named it), which need not run yet, as `name`, by which others see this program.
 Both are 1 to 64 of the characters a-z A-Z 0-9 _ -. The environment variable CNCBF_IPC_PREFIX chooses the group of stacks, as
 for every process.

 Fills in `node`, which belongs to the caller until cncbf_node_close().
 */
enum cncbf_result_t cncbf_node_open(const char *instance, const char *name, struct cncbf_node_t **node);

/*
 Gives the membership back. Readers and the place opened from it may live longer. A null pointer is allowed.
 */
void cncbf_node_close(struct cncbf_node_t *node);

/*
 Opens a reader of the messages of `type_name`, a CNCBF_..._TYPE_NAME of cncbf_messages.h. Writers and readers may start in any
 order.

 Fills in `reader`, which belongs to the caller until cncbf_reader_close().
 */
enum cncbf_result_t cncbf_reader_open(const struct cncbf_node_t *node, const char *type_name, struct cncbf_reader_t **reader);

/*
 Copies the newest message that has arrived since the last call into `message`, which has `size` bytes: the size of the structure
 that belongs to the reader's type name. Never waits. CNCBF_RESULT_NOTHING if none has arrived; `message` is left alone then.
 */
enum cncbf_result_t cncbf_reader_newest(struct cncbf_reader_t *reader, void *message, size_t size);

/*
 Gives a reader back. A null pointer is allowed.
 */
void cncbf_reader_close(struct cncbf_reader_t *reader);

/*
 Takes the nominal controller's place in the stack. One living program has it at a time; who asks while another one has it waits
 up to `patience_ns` nanoseconds until it is free, and gets CNCBF_RESULT_TAKEN if it is not. Ask again as often as you like: a
 program that shall follow another one does so between two looks at its own wish to stop.

 Fills in `place`, which belongs to the caller until cncbf_nominal_close(). Close it when the program ends: the place of a
 program that was killed stays taken for a tenth of a second after somebody else wants it.
 */
enum cncbf_result_t cncbf_nominal_open(const struct cncbf_node_t *node, uint64_t patience_ns, struct cncbf_nominal_t **place);

/*
 Sleeps until the bridge has sent a robot state, or until the stack clock shows `due_ns`. CNCBF_RESULT_OK: a robot state is there;
 several since the last call count as one. CNCBF_RESULT_NOTHING: time is up, or a signal came in between.
 */
enum cncbf_result_t cncbf_nominal_wait(struct cncbf_nominal_t *place, uint64_t due_ns);

/*
 Hands a copy of `command` to the filter and to whoever else reads it. Never waits. Stamp it just before.
 */
enum cncbf_result_t cncbf_nominal_send(struct cncbf_nominal_t *place, const cncbf_nominal_command_t *command);

/*
 Gives the place back, so that another program can have it. A null pointer is allowed.
 */
void cncbf_nominal_close(struct cncbf_nominal_t *place);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CNCBF_H */
