/* The two copies of a run file: an HDF5 file driver that writes into the hidden one and remembers
 * which pages it changed, and the exchange of the two. */
#include "record/twin.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { PAGE_BITS = 12, COPY_ROOM = 1 << 20 };

struct em_twin {
  char *asked;               /* the path as it was given, for messages */
  char *path, *next, *spare; /* visible, behind all links; hidden; name that keeps the old one while
                                it is replaced */
  char *claim;               /* name of the file whose lock is held as long as the work goes on */
  int claim_fd, fd;          /* of that file; of the hidden copy */
  uint64_t *dirty;           /* a bit per page that changed since the copies were equal */
  size_t dirty_words;
  uint64_t written; /* bytes: the hidden copy's length as HDF5 sees it */
  bool published;
  struct stat visible; /* the visible copy as it was when the copies were equal */
  _Atomic int error;   /* errno of the first failed write, by whatever thread */
  hid_t driver;
};

/* HDF5's handle of an open file. `head` must come first. */
struct handle {
  H5FD_t head;
  struct em_twin *twin;
  haddr_t eoa;
};

/* ---------------------------------------------------------------- bytes */

static int write_all(int fd, const void *data, size_t size, uint64_t at) {
  const char *from = data;
  while (size > 0) {
    const ssize_t n = pwrite(fd, from, size, (off_t)at);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n < 0 ? errno : EIO;
    from += n;
    at += (uint64_t)n;
    size -= (size_t)n;
  }
  return 0;
}

/* What lies beyond the end reads as zero. */
static int read_all(int fd, void *data, size_t size, uint64_t at) {
  char *to = data;
  while (size > 0) {
    const ssize_t n = pread(fd, to, size, (off_t)at);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) {
      memset(to, 0, size);
      return 0;
    }
    to += n;
    at += (uint64_t)n;
    size -= (size_t)n;
  }
  return 0;
}

static int copy_range(int from, int to, uint64_t at, uint64_t size) {
  char *room = malloc(COPY_ROOM);
  if (!room) return ENOMEM;
  int error = 0;
  while (size > 0 && !error) {
    const size_t part = size < COPY_ROOM ? (size_t)size : (size_t)COPY_ROOM;
    error = read_all(from, room, part, at);
    if (!error) error = write_all(to, room, part, at);
    at += part;
    size -= part;
  }
  free(room);
  return error;
}

static int file_size(int fd, uint64_t *size) {
  struct stat info;
  if (fstat(fd, &info) != 0) return errno;
  *size = (uint64_t)info.st_size;
  return 0;
}

static int copy_whole(int from, int to) {
  uint64_t size = 0;
  int error = file_size(from, &size);
  if (!error && ftruncate(to, 0) != 0) error = errno;
  return error ? error : copy_range(from, to, 0, size);
}

/* ---------------------------------------------------------------- pages that changed */

static bool mark(struct em_twin *twin, uint64_t at, size_t size) {
  if (size == 0) return true;
  const uint64_t first = at >> PAGE_BITS, last = (at + size - 1) >> PAGE_BITS;
  const size_t words = (size_t)(last / 64 + 1);
  if (words > twin->dirty_words) {
    const size_t room = words + words / 2 + 64;
    uint64_t *more = realloc(twin->dirty, room * sizeof *more);
    if (!more) return false;
    memset(more + twin->dirty_words, 0, (room - twin->dirty_words) * sizeof *more);
    twin->dirty = more;
    twin->dirty_words = room;
  }
  for (uint64_t page = first; page <= last; page++)
    twin->dirty[page / 64] |= UINT64_C(1) << (page % 64);
  return true;
}

static bool is_marked(const struct em_twin *twin, uint64_t page) {
  return page / 64 < twin->dirty_words && (twin->dirty[page / 64] >> (page % 64) & 1);
}

/* Copies the runs of pages that changed, and the length. */
static int copy_marked(struct em_twin *twin, int from, int to) {
  uint64_t size = 0;
  int error = file_size(from, &size);
  const uint64_t pages = (size + (UINT64_C(1) << PAGE_BITS) - 1) >> PAGE_BITS;
  for (uint64_t page = 0; page < pages && !error; page++) {
    const uint64_t first = page;
    while (page < pages && is_marked(twin, page))
      page++;
    if (page == first) continue;
    const uint64_t begin = first << PAGE_BITS;
    const uint64_t end = page << PAGE_BITS < size ? page << PAGE_BITS : size;
    error = copy_range(from, to, begin, end - begin);
  }
  if (!error && ftruncate(to, (off_t)size) != 0) error = errno;
  return error;
}

/* ---------------------------------------------------------------- the driver */

struct access {
  struct em_twin *twin;
};

static H5FD_t *driver_open(const char *name, unsigned flags, hid_t fapl, haddr_t maxaddr) {
  (void)name;
  (void)maxaddr;
  const struct access *info = H5Pget_driver_info(fapl);
  struct handle *h = info ? calloc(1, sizeof *h) : NULL;
  if (!h) return NULL;
  h->twin = info->twin;
  if (flags & H5F_ACC_TRUNC) {
    h->twin->written = 0;
    if (ftruncate(h->twin->fd, 0) != 0) h->twin->error = errno;
  } else if (file_size(h->twin->fd, &h->twin->written) != 0) {
    free(h);
    return NULL;
  }
  return &h->head;
}

static herr_t driver_close(H5FD_t *head) {
  free((struct handle *)head);
  return 0;
}

static int driver_compare(const H5FD_t *a, const H5FD_t *b) {
  const uintptr_t x = (uintptr_t)((const struct handle *)a)->twin;
  const uintptr_t y = (uintptr_t)((const struct handle *)b)->twin;
  return x < y ? -1 : x > y;
}

static herr_t driver_query(const H5FD_t *head, unsigned long *flags) {
  (void)head;
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

static haddr_t driver_eoa(const H5FD_t *head, H5FD_mem_t type) {
  (void)type;
  return ((const struct handle *)head)->eoa;
}

static herr_t driver_set_eoa(H5FD_t *head, H5FD_mem_t type, haddr_t addr) {
  (void)type;
  ((struct handle *)head)->eoa = addr;
  return 0;
}

static haddr_t driver_eof(const H5FD_t *head, H5FD_mem_t type) {
  (void)type;
  return ((const struct handle *)head)->twin->written;
}

static herr_t driver_read(H5FD_t *head, H5FD_mem_t type, hid_t dxpl, haddr_t at, size_t size,
                          void *data) {
  (void)type;
  (void)dxpl;
  return read_all(((struct handle *)head)->twin->fd, data, size, at) ? -1 : 0;
}

/* After a failure all writes seem to succeed, so that HDF5 can close what it has open; the copy is
 * never published. */
static herr_t driver_write(H5FD_t *head, H5FD_mem_t type, hid_t dxpl, haddr_t at, size_t size,
                           const void *data) {
  (void)type;
  (void)dxpl;
  struct em_twin *twin = ((struct handle *)head)->twin;
  if (!twin->error)
    twin->error = mark(twin, at, size) ? write_all(twin->fd, data, size, at) : ENOMEM;
  if (at + size > twin->written) twin->written = at + size;
  return 0;
}

static herr_t driver_truncate(H5FD_t *head, hid_t dxpl, hbool_t closing) {
  (void)dxpl;
  (void)closing;
  struct handle *h = (struct handle *)head;
  struct em_twin *twin = h->twin;
  if (h->eoa == twin->written) return 0;
  if (!twin->error && ftruncate(twin->fd, (off_t)h->eoa) != 0) twin->error = errno;
  twin->written = h->eoa;
  return 0;
}

static hid_t driver_register(void) {
  const H5FD_class_t class = {
      .name = "eventmill twin",
      .maxaddr = INT64_MAX,
      .fc_degree = H5F_CLOSE_STRONG,
      .fapl_size = sizeof(struct access),
      .open = driver_open,
      .close = driver_close,
      .cmp = driver_compare,
      .query = driver_query,
      .get_eoa = driver_eoa,
      .set_eoa = driver_set_eoa,
      .get_eof = driver_eof,
      .read = driver_read,
      .write = driver_write,
      .truncate = driver_truncate,
      .fl_map = H5FD_FLMAP_DICHOTOMY,
  };
  return H5FDregister(&class);
}

/* ---------------------------------------------------------------- the two files */

/* A lock that ends with the process. */
static bool lock(int fd) {
  struct flock region = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  return fcntl(fd, F_OFD_SETLK, &region) == 0 || (errno != EAGAIN && errno != EACCES);
}

static enum em_status cannot(const struct em_twin *twin, int error, struct em_error *err) {
  return em_error_set(err, EM_FILE, twin->asked, 0, "cannot be written: %s", strerror(error));
}

static char *name_with(const char *path, const char *ending) {
  char *name = NULL;
  return asprintf(&name, "%s%s", path, ending) < 0 ? NULL : name;
}

/* A writable file is a plain one, or none yet. */
static enum em_status check_target(const struct em_twin *twin, struct em_error *err) {
  struct stat info;
  if (stat(twin->path, &info) != 0) return errno == ENOENT ? EM_OK : cannot(twin, errno, err);
  if (!S_ISREG(info.st_mode))
    return em_error_set(err, EM_FILE, twin->asked, 0, "is not a plain file");
  if (access(twin->path, W_OK) != 0) return cannot(twin, errno, err);
  return EM_OK;
}

/* The name of the file that `path` means behind all links, be it there or not. NULL: errno. */
static char *resolve(const char *path) {
  char *real = realpath(path, NULL), target[PATH_MAX];
  if (real || errno != ENOENT) return real;
  const ssize_t n = readlink(path, target, sizeof target - 1);
  if (n < 0) return strdup(path);
  target[n] = '\0';
  const char *slash = strrchr(path, '/');
  char *name = NULL;
  if (target[0] == '/' || !slash) return resolve(target);
  if (asprintf(&name, "%.*s/%s", (int)(slash - path), path, target) < 0) return NULL;
  real = resolve(name);
  free(name);
  return real;
}

static bool is_named(int fd, const char *path) {
  struct stat open, named;
  return fstat(fd, &open) == 0 && stat(path, &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

/* Locks the file of that name, which only its holder removes: whoever got a lock on a file that has
 * been removed begins again. A process that was killed a moment ago may still hold its lock while
 * the disk is busy: 3 s. */
static enum em_status take_claim(struct em_twin *twin, struct em_error *err) {
  const struct timespec pause = {.tv_nsec = 50000000};
  for (int tries = 0; tries < 60; tries++) {
    const int fd = open(twin->claim, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (fd < 0) return cannot(twin, errno, err);
    if (lock(fd) && is_named(fd, twin->claim)) {
      twin->claim_fd = fd;
      return EM_OK;
    }
    close(fd);
    (void)nanosleep(&pause, NULL);
  }
  return em_error_set(err, EM_FILE, twin->asked, 0, "another process is writing this run");
}

static enum em_status copy_visible(struct em_twin *twin, struct em_error *err) {
  const int fd = open(twin->path, O_RDONLY | O_CLOEXEC);
  if (fd < 0)
    return em_error_set(err, EM_FILE, twin->asked, 0, "cannot be read: %s", strerror(errno));
  const int error = fstat(fd, &twin->visible) != 0 ? errno : copy_whole(fd, twin->fd);
  close(fd);
  twin->published = true;
  return error ? cannot(twin, error, err) : EM_OK;
}

static enum em_status set_names(struct em_twin *twin, const char *path, struct em_error *err) {
  twin->asked = name_with(path, "");
  twin->path = resolve(path);
  if (!twin->path && errno != ENOMEM)
    return em_error_set(err, EM_FILE, path, 0, "cannot be written: %s", strerror(errno));
  if (twin->path) {
    twin->next = name_with(twin->path, ".next");
    twin->spare = name_with(twin->path, ".prev");
    twin->claim = name_with(twin->path, ".lock");
  }
  twin->driver = driver_register();
  if (twin->asked && twin->next && twin->spare && twin->claim && twin->driver >= 0) return EM_OK;
  return em_error_set(err, EM_MEMORY, path, 0, "out of memory");
}

enum em_status em_twin_new(struct em_twin **out, const char *path, struct em_error *err) {
  struct em_twin *twin = calloc(1, sizeof *twin);
  if (!twin) return em_error_set(err, EM_MEMORY, path, 0, "out of memory");
  twin->fd = twin->claim_fd = -1;
  enum em_status status = set_names(twin, path, err);
  if (!status) status = check_target(twin, err);
  if (!status) status = take_claim(twin, err);
  if (status) {
    em_twin_free(twin);
    return status;
  }
  *out = twin;
  return EM_OK;
}

/* A new hidden copy, which those may read who may read PATH; negative: errno. */
static int open_hidden(const struct em_twin *twin) {
  struct stat info;
  const int fd = open(twin->next, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd >= 0 && stat(twin->path, &info) == 0) (void)fchmod(fd, info.st_mode & 0777);
  return fd;
}

enum em_status em_twin_begin(struct em_twin *twin, bool from_existing, struct em_error *err) {
  twin->fd = open_hidden(twin);
  if (twin->fd < 0) return cannot(twin, errno, err);
  (void)unlink(twin->spare);
  return from_existing ? copy_visible(twin, err) : EM_OK;
}

void em_twin_free(struct em_twin *twin) {
  if (!twin) return;
  if (twin->fd >= 0) {
    (void)unlink(twin->next);
    (void)unlink(twin->spare);
    close(twin->fd);
  }
  if (twin->claim_fd >= 0) {
    (void)unlink(twin->claim);
    close(twin->claim_fd);
  }
  if (twin->driver > 0) H5FDunregister(twin->driver);
  free(twin->asked);
  free(twin->path);
  free(twin->next);
  free(twin->spare);
  free(twin->claim);
  free(twin->dirty);
  free(twin);
}

hid_t em_twin_access(struct em_twin *twin) {
  const hid_t fapl = H5Pcreate(H5P_FILE_ACCESS);
  const struct access info = {twin};
  if (fapl >= 0 && H5Pset_driver(fapl, twin->driver, &info) < 0) {
    H5Pclose(fapl);
    return -1;
  }
  return fapl;
}

const char *em_twin_name(const struct em_twin *twin) {
  return twin->next;
}

/* Is it the file that was published, and has nobody replaced or changed it since? */
static bool is_unchanged(const struct em_twin *twin, const struct stat *info) {
  const struct stat *was = &twin->visible;
  return info->st_dev == was->st_dev && info->st_ino == was->st_ino &&
         info->st_size == was->st_size && info->st_mtim.tv_sec == was->st_mtim.tv_sec &&
         info->st_mtim.tv_nsec == was->st_mtim.tv_nsec;
}

/* The old visible file under its spare name, so that it outlives the rename; -1: there is none, or
 * the file system has no hard links, or somebody has changed it or given it a third name. */
static int keep_old(const struct em_twin *twin) {
  struct stat info;
  (void)unlink(twin->spare);
  if (!twin->published || link(twin->path, twin->spare) != 0) return -1;
  const int fd = open(twin->spare, O_RDWR | O_CLOEXEC);
  if (fd >= 0 && fstat(fd, &info) == 0 && info.st_nlink == 2 && is_unchanged(twin, &info))
    return fd;
  if (fd >= 0) close(fd);
  (void)unlink(twin->spare);
  return -1;
}

/* Has somebody else the file open? A lease is given for a file that is open once; where there are
 * no leases, readers are those that lock it, as HDF5 does. The signal of a lease that is broken
 * would be SIGIO, which ends the program; SIGURG does nothing. */
static bool is_read(int fd) {
  if (fcntl(fd, F_SETSIG, SIGURG) == 0 && fcntl(fd, F_SETLEASE, F_WRLCK) == 0) {
    (void)fcntl(fd, F_SETLEASE, F_UNLCK);
    return false;
  }
  if (errno == EAGAIN || flock(fd, LOCK_EX | LOCK_NB) != 0) return true;
  (void)flock(fd, LOCK_UN);
  return false;
}

/* Forces the names in the file's folder to the disk; false: that cannot be done here. Until then
 * PATH may come back after a crash of the machine as the old file, which must be whole. */
static bool settle_names(const struct em_twin *twin) {
  const char *slash = strrchr(twin->path, '/');
  char *folder = slash ? strndup(twin->path, (size_t)(slash - twin->path) + 1) : strdup(".");
  const int fd = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
  const bool good = fd >= 0 && fsync(fd) == 0;
  if (fd >= 0) close(fd);
  free(folder);
  return good;
}

/* Makes `old` (the former visible file, or -1) the hidden copy, equal to the visible one. */
static int renew_hidden(struct em_twin *twin, int old) {
  int error = 0;
  if (old >= 0) {
    if (rename(twin->spare, twin->next) != 0) error = errno;
    if (!error) error = copy_marked(twin, twin->fd, old);
  } else {
    old = open_hidden(twin);
    if (old < 0) return errno;
    error = copy_whole(twin->fd, old);
  }
  close(twin->fd);
  twin->fd = old;
  if (twin->dirty) memset(twin->dirty, 0, twin->dirty_words * sizeof *twin->dirty);
  return error;
}

enum em_status em_twin_publish(struct em_twin *twin, bool last, struct em_error *err) {
  if (!twin->error && fdatasync(twin->fd) != 0 && errno != EINVAL && errno != EROFS)
    twin->error = errno;
  if (twin->error) return cannot(twin, twin->error, err);
  int old = last ? -1 : keep_old(twin);
  struct stat info;
  if (fstat(twin->fd, &info) == 0) twin->visible = info;
  if (rename(twin->next, twin->path) != 0) {
    twin->error = errno;
    if (old >= 0) close(old);
    (void)unlink(twin->spare);
    return cannot(twin, twin->error, err);
  }
  twin->published = true;
  const bool settled = settle_names(twin);
  if (old >= 0 && (!settled || is_read(old))) {
    close(old);
    (void)unlink(twin->spare);
    old = -1;
  }
  if (last) {
    close(twin->fd);
    twin->fd = -1;
    return EM_OK;
  }
  twin->error = renew_hidden(twin, old);
  return twin->error ? cannot(twin, twin->error, err) : EM_OK;
}

bool em_twin_is_published(const struct em_twin *twin) {
  return twin->published;
}

int em_twin_errno(const struct em_twin *twin) {
  return twin->error;
}
