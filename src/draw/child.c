/* Starts a program and feeds it. A socket stands for the pipe, because writing to one whose other
 * end is closed can be told from a signal (MSG_NOSIGNAL) without changing the process's settings.
 */
#include "draw/child.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* In the new process: connects the descriptors and becomes the program. Returns only on failure;
 * tells the parent why through `fault`. */
static void become(const char *const *argv, int input, int output, int report, int fault) {
  const int null = open("/dev/null", O_RDWR);
  const int out = output >= 0 ? output : null;
  if (null >= 0 && dup2(input, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0 &&
      dup2(report, STDERR_FILENO) >= 0) {
    signal(SIGPIPE, SIG_DFL);
    setpgid(0, 0); /* Ctrl-C ends us, and we end the program */
    execvp(argv[0], (char *const *)(size_t)argv);
  }
  const int code = errno;
  if (write(fault, &code, sizeof code) < 0) _Exit(126);
  _Exit(127);
}

enum em_status em_child_start(struct em_child *child, const char *const *argv, int output,
                              struct em_error *err) {
  int pair[2] = {-1, -1}, fault[2] = {-1, -1}, code = 0;
  *child = (struct em_child){.pid = -1, .input = -1, .report = -1, .name = argv[0]};
  child->report = memfd_create("report", MFD_CLOEXEC);
  if (child->report < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0 ||
      pipe2(fault, O_CLOEXEC) != 0 || (child->pid = fork()) < 0) {
    code = errno;
  } else if (child->pid == 0) {
    become(argv, pair[0], output, child->report, fault[1]);
  }
  if (pair[0] >= 0) close(pair[0]);
  if (fault[1] >= 0) close(fault[1]);
  child->input = pair[1];
  if (code == 0 && read(fault[0], &code, sizeof code) != (ssize_t)sizeof code) code = 0;
  if (fault[0] >= 0) close(fault[0]);
  if (code == 0) {
    const int room = 4 << 20;
    setsockopt(child->input, SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    return EM_OK;
  }
  em_child_abandon(child);
  return em_error_set(err, EM_PICTURE, NULL, 0, "%s cannot be started: %s", argv[0],
                      strerror(code));
}

/* The first lines of what the program said. */
static void read_report(const struct em_child *child, char *text, size_t size) {
  const ssize_t got = pread(child->report, text, size - 1, 0);
  size_t length = got > 0 ? (size_t)got : 0;
  while (length > 0 && (text[length - 1] == '\n' || text[length - 1] == ' '))
    length--;
  text[length] = '\0';
}

/* Waits for the program; its wait status, or -1. */
static int reap(struct em_child *child) {
  int state = -1;
  if (child->input >= 0) close(child->input);
  child->input = -1;
  while (child->pid > 0 && waitpid(child->pid, &state, 0) < 0)
    if (errno != EINTR) break;
  child->pid = -1;
  return state;
}

static void forget_report(struct em_child *child) {
  if (child->report >= 0) close(child->report);
  child->report = -1;
}

enum em_status em_child_send(struct em_child *child, const void *data, size_t size,
                             struct em_error *err) {
  const char *rest = data;
  while (size > 0) {
    const ssize_t sent = send(child->input, rest, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      char said[512];
      const int code = errno;
      reap(child);
      read_report(child, said, sizeof said);
      return em_error_set(err, EM_PICTURE, NULL, 0, "%s ended too early: %s", child->name,
                          said[0] != '\0' ? said : strerror(code));
    }
    rest += sent;
    size -= (size_t)sent;
  }
  return EM_OK;
}

enum em_status em_child_finish(struct em_child *child, struct em_error *err) {
  char said[512];
  const int state = reap(child);
  read_report(child, said, sizeof said);
  forget_report(child);
  if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return EM_OK;
  return em_error_set(err, EM_PICTURE, NULL, 0, "%s failed: %s", child->name,
                      said[0] != '\0' ? said : "it did not say why");
}

void em_child_abandon(struct em_child *child) {
  if (child->pid > 0) kill(child->pid, SIGTERM);
  reap(child);
  forget_report(child);
}
