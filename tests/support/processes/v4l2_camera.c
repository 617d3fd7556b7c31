/* V4L2 devices that are not there, for one process: preloaded, it answers for the two paths in
 * V4L2_CAMERA (a camera with YUYV at 640 x 480 that never delivers a picture) and V4L2_METADATA
 * (the second node of such a camera). As a real driver does, it refuses a second opener the
 * format while the first one streams. V4L2_HANG_S: a dequeue hangs in the driver for so long
 * instead of saying that nothing is there. V4L2_LOG: a file that gets a line for each request. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MOST_FDS = 1024, BUFFER_BYTES = 640 * 480 * 2 };
enum kind { NOTHING, CAMERA, METADATA };
static enum kind kinds[MOST_FDS];
static int streaming_fd = -1;
static unsigned rate_hz = 15;

static void note(const char *what, unsigned value)
{
    const char *path = getenv("V4L2_LOG");
    FILE *log = path ? fopen(path, "a") : NULL;
    if (log) {
        fprintf(log, "%s %u\n", what, value);
        fclose(log);
    }
}

static enum kind kind_of(const char *path)
{
    const char *camera = getenv("V4L2_CAMERA"), *metadata = getenv("V4L2_METADATA");
    if (camera && strcmp(path, camera) == 0)
        return CAMERA;
    return metadata && strcmp(path, metadata) == 0 ? METADATA : NOTHING;
}

static int open_device(enum kind kind)
{
    int ends[2]; /* the reading end never becomes readable: its writing end stays open */
    if (pipe(ends) != 0)
        return -1;
    if (ends[0] >= MOST_FDS) {
        errno = EMFILE;
        return -1;
    }
    kinds[ends[0]] = kind;
    return ends[0];
}

#define OPEN(name)                                                      \
    int name(const char *path, int flags, ...)                          \
    {                                                                   \
        va_list rest;                                                   \
        va_start(rest, flags);                                          \
        int mode = va_arg(rest, int);                                   \
        va_end(rest);                                                   \
        enum kind kind = kind_of(path);                                 \
        if (kind != NOTHING)                                            \
            return open_device(kind);                                   \
        int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, #name);  \
        return real(path, flags, mode);                                 \
    }
OPEN(open)
OPEN(open64)

int close(int fd)
{
    int (*real)(int) = dlsym(RTLD_NEXT, "close");
    if (fd >= 0 && fd < MOST_FDS && kinds[fd] != NOTHING) {
        kinds[fd] = NOTHING;
        if (streaming_fd == fd)
            streaming_fd = -1;
    }
    return real(fd);
}

#define MMAP(name)                                                                      \
    void *name(void *at, size_t length, int protection, int flags, int fd, off_t where) \
    {                                                                                   \
        void *(*real)(void *, size_t, int, int, int, off_t) = dlsym(RTLD_NEXT, #name);  \
        if (fd >= 0 && fd < MOST_FDS && kinds[fd] == CAMERA)                            \
            return real(at, length, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);    \
        return real(at, length, protection, flags, fd, where);                          \
    }
MMAP(mmap)
MMAP(mmap64)

static int failed(int number)
{
    errno = number;
    return -1;
}

static int capabilities(enum kind kind, struct v4l2_capability *out)
{
    memset(out, 0, sizeof *out);
    strcpy((char *)out->driver, "uvcvideo");
    strcpy((char *)out->card, "Fake camera");
    /* what the whole device can do, and what this node of it can */
    out->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING
                        | V4L2_CAP_DEVICE_CAPS;
    out->device_caps = (kind == CAMERA ? V4L2_CAP_VIDEO_CAPTURE : V4L2_CAP_META_CAPTURE)
                       | V4L2_CAP_STREAMING;
    return 0;
}

static int format(struct v4l2_format *out)
{
    out->fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
    out->fmt.pix.width = 640;
    out->fmt.pix.height = 480;
    out->fmt.pix.bytesperline = 640 * 2;
    out->fmt.pix.sizeimage = BUFFER_BYTES;
    return 0;
}

static int dequeue(void)
{
    const char *hang_s = getenv("V4L2_HANG_S");
    if (hang_s)
        sleep((unsigned)atoi(hang_s));
    return failed(EAGAIN);
}

static int answer(int fd, unsigned long request, void *data)
{
    int is_busy = streaming_fd >= 0 && streaming_fd != fd;
    switch (request) {
    case VIDIOC_QUERYCAP:
        return capabilities(kinds[fd], data);
    case VIDIOC_G_FMT:
        return kinds[fd] == CAMERA ? format(data) : failed(EINVAL);
    case VIDIOC_S_FMT:
        if (is_busy)
            return failed(EBUSY);
        note("format", ((struct v4l2_format *)data)->fmt.pix.pixelformat);
        rate_hz = 15; /* as drivers do: a new format begins at its own rate */
        return format(data);
    case VIDIOC_S_PARM:
        rate_hz = ((struct v4l2_streamparm *)data)->parm.capture.timeperframe.denominator;
        note("rate", rate_hz);
        return 0;
    case VIDIOC_G_PARM:
        ((struct v4l2_streamparm *)data)->parm.capture.timeperframe.numerator = 1;
        ((struct v4l2_streamparm *)data)->parm.capture.timeperframe.denominator = rate_hz;
        return 0;
    case VIDIOC_REQBUFS:
        return is_busy ? failed(EBUSY) : 0;
    case VIDIOC_QUERYBUF:
        ((struct v4l2_buffer *)data)->length = BUFFER_BYTES;
        return 0;
    case VIDIOC_QBUF:
        return 0;
    case VIDIOC_STREAMON:
        if (is_busy)
            return failed(EBUSY);
        streaming_fd = fd;
        return 0;
    case VIDIOC_STREAMOFF:
        streaming_fd = streaming_fd == fd ? -1 : streaming_fd;
        return 0;
    case VIDIOC_DQBUF:
        return dequeue();
    default:
        return failed(EINVAL);
    }
}

int ioctl(int fd, unsigned long request, ...)
{
    va_list rest;
    va_start(rest, request);
    void *data = va_arg(rest, void *);
    va_end(rest);
    /* Python hands its number on as a signed one */
    if (fd >= 0 && fd < MOST_FDS && kinds[fd] != NOTHING)
        return answer(fd, request & 0xffffffffUL, data);
    int (*real)(int, unsigned long, ...) = dlsym(RTLD_NEXT, "ioctl");
    return real(fd, request, data);
}
