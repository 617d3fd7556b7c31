/* V4L2 devices that are not there, for one process: preloaded, it answers for the paths in
 * V4L2_CAMERA (cameras, between colons) and V4L2_METADATA (the second node of such a camera). The
 * environment is read at each request, so that a test may change it while the program runs:
 *
 * V4L2_MODES    what the cameras offer, as in "YUYV:1280x960@10,640x480@30;MJPG:1280x960@30@15";
 *               a size without a rate lists none. Default: YUYV:640x480
 * V4L2_DELIVER  pictures come, at the rate agreed on; without it none ever does
 * V4L2_REAL_HZ  they come at this rate, whatever was agreed on
 * V4L2_JPEGS    files, between colons, which an MJPG camera gives in turn
 * V4L2_FAULT    error (a picture marked as damaged), cut (half a picture), eio, enodev, hang
 *               (none comes), wrap (stamps of no clock), future; V4L2_EVERY: each so-many-th only
 * V4L2_REFUSE   the control with this number is refused; V4L2_STUCK: it keeps its value
 * V4L2_NOSPACE  USB has no room for this format
 * V4L2_CARD     the camera's name; V4L2_PLUG: another value is another plug: controls begin again
 * V4L2_HANG_S   a dequeue hangs in the driver for so long instead of saying that nothing is there
 * V4L2_LOG      a file that gets a line for each format, rate and control
 *
 * As real drivers do, it refuses a second opener the format while the first one streams, begins a
 * new format at its own rate, halves the rate while automatic exposure may (a dark room), and
 * refuses an exposure time while exposure is automatic. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

enum { MOST_FDS = 1024, MOST_BUFFERS = 8, MOST_MODES = 32, MOST_RATES = 8 };
enum { BUFFER_BYTES = 1280 * 960 * 2 };
enum kind { NOTHING, CAMERA, METADATA };

struct device {
    enum kind kind;
    char name[64];
    void *maps[MOST_BUFFERS];
    unsigned queue[MOST_BUFFERS], queued;
    unsigned number;
};
struct mode {
    uint32_t fourcc;
    unsigned width, height, rates[MOST_RATES], count;
};
struct control {
    uint32_t id, type;
    const char *name;
    int32_t least, most, step, initial, value;
};

static struct device devices[MOST_FDS];
static int streaming_fd = -1;
static struct mode agreed = {V4L2_PIX_FMT_YUYV, 640, 480, {15}, 1};
static unsigned rate_hz = 15;
static unsigned dark_pictures;
static char plug[64];
static struct control controls[] = {
    {V4L2_CID_AUTO_WHITE_BALANCE, V4L2_CTRL_TYPE_BOOLEAN, "White Balance, Automatic", 0, 1, 1, 1, 1},
    {V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 255, 1, 64, 64},
    {V4L2_CID_POWER_LINE_FREQUENCY, V4L2_CTRL_TYPE_MENU, "Power Line Frequency", 0, 2, 1, 2, 2},
    {V4L2_CID_WHITE_BALANCE_TEMPERATURE, V4L2_CTRL_TYPE_INTEGER, "White Balance Temperature",
     2800, 6500, 10, 4600, 4600},
    {V4L2_CID_EXPOSURE_AUTO, V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 1, 3, 3},
    {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Exposure Time, Absolute",
     3, 2047, 1, 250, 250},
    {V4L2_CID_EXPOSURE_AUTO_PRIORITY, V4L2_CTRL_TYPE_BOOLEAN, "Exposure, Dynamic Framerate",
     0, 1, 1, 1, 1},
    {V4L2_CID_FOCUS_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Focus, Absolute", 0, 250, 5, 0, 0},
    {V4L2_CID_FOCUS_AUTO, V4L2_CTRL_TYPE_BOOLEAN, "Focus, Automatic Continuous", 0, 1, 1, 1, 1},
};
enum { CONTROLS = sizeof controls / sizeof controls[0] };

static void note(const char *what, unsigned value)
{
    const char *path = getenv("V4L2_LOG");
    FILE *log = path ? fopen(path, "a") : NULL;
    if (log) {
        fprintf(log, "%s %u\n", what, value);
        fclose(log);
    }
}

static int is_among(const char *path, const char *list)
{
    size_t length = strlen(path);
    for (const char *at = list; at && *at; at = strchr(at, ':') ? strchr(at, ':') + 1 : NULL)
        if (strncmp(at, path, length) == 0 && (at[length] == ':' || at[length] == 0))
            return 1;
    return 0;
}

static enum kind kind_of(const char *path)
{
    if (is_among(path, getenv("V4L2_CAMERA")))
        return CAMERA;
    return is_among(path, getenv("V4L2_METADATA")) ? METADATA : NOTHING;
}

static struct device *device_of(int fd)
{
    return fd >= 0 && fd < MOST_FDS && devices[fd].kind != NOTHING ? &devices[fd] : NULL;
}

static int open_device(enum kind kind, const char *path)
{
    int fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC); /* readable: a picture */
    if (fd < 0)
        return -1;
    if (fd >= MOST_FDS) {
        errno = EMFILE;
        return -1;
    }
    memset(&devices[fd], 0, sizeof devices[fd]);
    devices[fd].kind = kind;
    const char *name = strrchr(path, '/');
    snprintf(devices[fd].name, sizeof devices[fd].name, "%s", name ? name + 1 : path);
    const char *now = getenv("V4L2_PLUG");
    if (now && strcmp(now, plug) != 0) {
        snprintf(plug, sizeof plug, "%s", now);
        for (unsigned i = 0; i < CONTROLS; i++)
            controls[i].value = controls[i].initial;
    }
    return fd;
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
            return open_device(kind, path);                             \
        int (*real)(const char *, int, ...) = dlsym(RTLD_NEXT, #name);  \
        return real(path, flags, mode);                                 \
    }
OPEN(open)
OPEN(open64)

int close(int fd)
{
    int (*real)(int) = dlsym(RTLD_NEXT, "close");
    if (device_of(fd)) {
        devices[fd].kind = NOTHING;
        if (streaming_fd == fd)
            streaming_fd = -1;
    }
    return real(fd);
}

static void *map_device(void *(*real)(void *, size_t, int, int, int, off_t), size_t length,
                        struct device *of, off_t where)
{
    void *made = real(NULL, length, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    unsigned index = (unsigned)(where / BUFFER_BYTES);
    if (made != MAP_FAILED && index < MOST_BUFFERS)
        of->maps[index] = made;
    return made;
}

#define MMAP(name)                                                                      \
    void *name(void *at, size_t length, int protection, int flags, int fd, off_t where) \
    {                                                                                   \
        void *(*real)(void *, size_t, int, int, int, off_t) = dlsym(RTLD_NEXT, #name);  \
        if (device_of(fd))                                                              \
            return map_device(real, length, &devices[fd], where);                       \
        return real(at, length, protection, flags, fd, where);                          \
    }
MMAP(mmap)
MMAP(mmap64)

static int failed(int number)
{
    errno = number;
    return -1;
}

static unsigned list_modes(struct mode *out)
{
    const char *at = getenv("V4L2_MODES");
    unsigned count = 0;
    char letters[5];
    at = at ? at : "YUYV:640x480";
    while (count < MOST_MODES && sscanf(at, "%4[^:]:", letters) == 1) {
        uint32_t fourcc = v4l2_fourcc(letters[0], letters[1], letters[2], letters[3]);
        at = strchr(at, ':');
        while (at && (*at == ':' || *at == ',') && count < MOST_MODES) {
            struct mode *mode = &out[count++];
            memset(mode, 0, sizeof *mode);
            mode->fourcc = fourcc;
            mode->width = (unsigned)strtoul(at + 1, (char **)&at, 10);
            mode->height = (unsigned)strtoul(at + 1, (char **)&at, 10);
            while (*at == '@' && mode->count < MOST_RATES)
                mode->rates[mode->count++] = (unsigned)strtoul(at + 1, (char **)&at, 10);
        }
        if (!at || *at != ';')
            break;
        at++;
    }
    return count;
}

static int capabilities(struct device *of, struct v4l2_capability *out)
{
    const char *card = getenv("V4L2_CARD");
    memset(out, 0, sizeof *out);
    strcpy((char *)out->driver, "uvcvideo");
    snprintf((char *)out->card, sizeof out->card, "%s", card ? card : "Fake camera");
    snprintf((char *)out->bus_info, sizeof out->bus_info, "usb-%.24s", of->name);
    /* what the whole device can do, and what this node of it can */
    out->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING
                        | V4L2_CAP_DEVICE_CAPS;
    out->device_caps = (of->kind == CAMERA ? V4L2_CAP_VIDEO_CAPTURE : V4L2_CAP_META_CAPTURE)
                       | V4L2_CAP_STREAMING;
    return 0;
}

static int list_format(struct v4l2_fmtdesc *out)
{
    struct mode modes[MOST_MODES];
    unsigned count = list_modes(modes), formats = 0;
    for (unsigned i = 0; i < count; i++)
        if ((i == 0 || modes[i].fourcc != modes[i - 1].fourcc) && formats++ == out->index) {
            out->pixelformat = modes[i].fourcc;
            return 0;
        }
    return failed(EINVAL);
}

static int list_size(struct v4l2_frmsizeenum *out)
{
    struct mode modes[MOST_MODES];
    unsigned count = list_modes(modes), sizes = 0;
    for (unsigned i = 0; i < count; i++)
        if (modes[i].fourcc == out->pixel_format && sizes++ == out->index) {
            out->type = V4L2_FRMSIZE_TYPE_DISCRETE;
            out->discrete.width = modes[i].width;
            out->discrete.height = modes[i].height;
            return 0;
        }
    return failed(EINVAL);
}

static int list_interval(struct v4l2_frmivalenum *out)
{
    struct mode modes[MOST_MODES];
    unsigned count = list_modes(modes);
    for (unsigned i = 0; i < count; i++)
        if (modes[i].fourcc == out->pixel_format && modes[i].width == out->width
            && modes[i].height == out->height && out->index < modes[i].count) {
            out->type = V4L2_FRMIVAL_TYPE_DISCRETE;
            out->discrete.numerator = 1;
            out->discrete.denominator = modes[i].rates[out->index];
            return 0;
        }
    return failed(EINVAL);
}

static int tell_format(struct v4l2_format *out)
{
    struct v4l2_pix_format *pix = &out->fmt.pix;
    unsigned bytes = agreed.fourcc == V4L2_PIX_FMT_YUYV ? 2 : 1;
    pix->pixelformat = agreed.fourcc;
    pix->width = agreed.width;
    pix->height = agreed.height;
    pix->bytesperline = agreed.fourcc == V4L2_PIX_FMT_MJPEG ? 0 : agreed.width * bytes;
    pix->sizeimage = BUFFER_BYTES;
    return 0;
}

/* The mode that is most like the one asked for: its format first, then its size. */
static int set_format(struct v4l2_format *form)
{
    struct mode modes[MOST_MODES];
    unsigned count = list_modes(modes);
    long least = -1;
    for (unsigned i = 0; i < count; i++) {
        long unlike = labs((long)modes[i].width - form->fmt.pix.width)
                      + labs((long)modes[i].height - form->fmt.pix.height)
                      + (modes[i].fourcc == form->fmt.pix.pixelformat ? 0 : 100000);
        if (least < 0 || unlike < least) {
            least = unlike;
            agreed = modes[i];
        }
    }
    note("format", agreed.fourcc);
    rate_hz = agreed.count ? agreed.rates[agreed.count - 1] : 15;
    return tell_format(form);
}

static int set_rate(struct v4l2_streamparm *out)
{
    struct v4l2_fract *span = &out->parm.capture.timeperframe;
    unsigned asked = (unsigned)(0.5 + (double)span->denominator / span->numerator);
    unsigned got = agreed.count ? agreed.rates[0] : asked;
    for (unsigned i = 0; i < agreed.count; i++)
        if (abs((int)agreed.rates[i] - (int)asked) < abs((int)got - (int)asked))
            got = agreed.rates[i];
    rate_hz = got;
    note("rate", rate_hz);
    span->numerator = 1;
    span->denominator = rate_hz;
    return 0;
}

static struct control *control_of(uint32_t id)
{
    for (unsigned i = 0; i < CONTROLS; i++)
        if (controls[i].id == id)
            return &controls[i];
    return NULL;
}

static int list_control(struct v4l2_queryctrl *out)
{
    uint32_t after = out->id & ~(uint32_t)V4L2_CTRL_FLAG_NEXT_CTRL;
    for (unsigned i = 0; i < CONTROLS; i++)
        if (out->id & V4L2_CTRL_FLAG_NEXT_CTRL ? controls[i].id > after : controls[i].id == out->id) {
            struct control *found = &controls[i];
            memset(out, 0, sizeof *out);
            out->id = found->id;
            out->type = found->type;
            strcpy((char *)out->name, found->name);
            out->minimum = found->least;
            out->maximum = found->most;
            out->step = found->step;
            out->default_value = found->initial;
            return 0;
        }
    return failed(EINVAL);
}

static int list_menu(struct v4l2_querymenu *out)
{
    /* as webcams do: exposure by hand, or automatic with the iris by hand */
    if (out->id == V4L2_CID_EXPOSURE_AUTO && out->index != 1 && out->index != 3)
        return failed(EINVAL);
    snprintf((char *)out->name, sizeof out->name, "Choice %u", out->index);
    return 0;
}

static int is_number(const char *variable, uint32_t id)
{
    const char *text = getenv(variable);
    return text && strtoul(text, NULL, 0) == id;
}

static int set_control(struct v4l2_control *wanted)
{
    struct control *found = control_of(wanted->id);
    if (!found)
        return failed(EINVAL);
    if (is_number("V4L2_REFUSE", wanted->id))
        return failed(EIO);
    if (wanted->id == V4L2_CID_EXPOSURE_ABSOLUTE && control_of(V4L2_CID_EXPOSURE_AUTO)->value != 1)
        return failed(EIO);
    if (!is_number("V4L2_STUCK", wanted->id))
        found->value = wanted->value;
    note(found->name, (unsigned)found->value);
    return 0;
}

static int stream_on(int fd)
{
    const char *full = getenv("V4L2_NOSPACE"), *real_hz = getenv("V4L2_REAL_HZ");
    if (full && memcmp(full, &agreed.fourcc, 4) == 0)
        return failed(ENOSPC);
    streaming_fd = fd;
    double hz = real_hz ? atof(real_hz) : rate_hz;
    long span = (long)(1e9 / hz);
    struct itimerspec timer = {{span / 1000000000, span % 1000000000},
                               {span / 1000000000, span % 1000000000}};
    if (getenv("V4L2_DELIVER"))
        timerfd_settime(fd, 0, &timer, NULL);
    return 0;
}

static int stream_off(int fd)
{
    struct itimerspec never = {{0, 0}, {0, 0}};
    timerfd_settime(fd, 0, &never, NULL);
    devices[fd].queued = 0;
    streaming_fd = streaming_fd == fd ? -1 : streaming_fd;
    return 0;
}

static size_t read_jpeg(unsigned number, uint8_t *out)
{
    char list[4096], *rest = list, *names[64];
    unsigned count = 0;
    snprintf(list, sizeof list, "%s", getenv("V4L2_JPEGS") ? getenv("V4L2_JPEGS") : "");
    for (char *name; count < 64 && (name = strsep(&rest, ":"));)
        names[count++] = name;
    FILE *file = fopen(names[number % count], "rb");
    size_t length = file ? fread(out, 1, BUFFER_BYTES, file) : 0;
    if (file)
        fclose(file);
    return length;
}

static size_t draw(unsigned number, uint8_t *out)
{
    if (agreed.fourcc == V4L2_PIX_FMT_MJPEG)
        return read_jpeg(number, out);
    size_t length = (size_t)agreed.width * agreed.height
                    * (agreed.fourcc == V4L2_PIX_FMT_YUYV ? 2 : 1);
    for (size_t i = 0; i < length; i++)
        out[i] = agreed.fourcc == V4L2_PIX_FMT_YUYV && i % 2 ? 128 : (uint8_t)(50 + number % 100);
    return length;
}

static int fill(struct device *from, struct v4l2_buffer *out, const char *fault)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    unsigned index = from->queue[0];
    memmove(from->queue, from->queue + 1, --from->queued * sizeof from->queue[0]);
    size_t length = draw(from->number, from->maps[index]);
    out->index = index;
    out->length = BUFFER_BYTES;
    out->bytesused = (uint32_t)(strcmp(fault, "cut") == 0 ? length / 2 : length);
    out->flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
                 | (strcmp(fault, "error") == 0 ? V4L2_BUF_FLAG_ERROR : 0);
    out->timestamp.tv_sec = now.tv_sec;
    out->timestamp.tv_usec = now.tv_nsec / 1000;
    if (strcmp(fault, "wrap") == 0)
        out->timestamp.tv_sec = 0x7fffffff - from->number % 3;
    if (strcmp(fault, "future") == 0)
        out->timestamp.tv_sec += 3;
    out->sequence = from->number++;
    return 0;
}

static int dequeue(int fd, struct v4l2_buffer *out)
{
    const char *hang_s = getenv("V4L2_HANG_S"), *fault = getenv("V4L2_FAULT");
    const char *every = getenv("V4L2_EVERY");
    struct device *from = &devices[fd];
    struct control *may_slow = control_of(V4L2_CID_EXPOSURE_AUTO_PRIORITY);
    uint64_t due;
    if (hang_s)
        sleep((unsigned)atoi(hang_s));
    fault = fault && (!every || from->number % (unsigned)atoi(every) == 0) ? fault : "";
    if (strcmp(fault, "enodev") == 0)
        return failed(ENODEV);
    if (read(fd, &due, sizeof due) != sizeof due)
        return failed(EAGAIN);
    int is_dark = may_slow->value && control_of(V4L2_CID_EXPOSURE_AUTO)->value == 3;
    if (strcmp(fault, "hang") == 0 || from->queued == 0 || (is_dark && ++dark_pictures % 2))
        return failed(EAGAIN);
    if (strcmp(fault, "eio") == 0) {
        from->number++;
        return failed(EIO);
    }
    return fill(from, out, fault);
}

static int queue(struct device *to, const struct v4l2_buffer *buffer)
{
    if (to->queued == MOST_BUFFERS || buffer->index >= MOST_BUFFERS)
        return failed(EINVAL);
    to->queue[to->queued++] = buffer->index;
    return 0;
}

static int answer(int fd, unsigned long request, void *data)
{
    int is_busy = streaming_fd >= 0 && streaming_fd != fd;
    struct device *of = &devices[fd];
    if (request == VIDIOC_QUERYCAP)
        return capabilities(of, data);
    if (of->kind != CAMERA)
        return failed(EINVAL);
    switch (request) {
    case VIDIOC_ENUM_FMT:
        return list_format(data);
    case VIDIOC_ENUM_FRAMESIZES:
        return list_size(data);
    case VIDIOC_ENUM_FRAMEINTERVALS:
        return list_interval(data);
    case VIDIOC_G_FMT:
        return tell_format(data);
    case VIDIOC_S_FMT:
        return is_busy ? failed(EBUSY) : set_format(data);
    case VIDIOC_S_PARM:
        return set_rate(data);
    case VIDIOC_G_PARM:
        ((struct v4l2_streamparm *)data)->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
        ((struct v4l2_streamparm *)data)->parm.capture.timeperframe.numerator = 1;
        ((struct v4l2_streamparm *)data)->parm.capture.timeperframe.denominator = rate_hz;
        return 0;
    case VIDIOC_QUERYCTRL:
        return list_control(data);
    case VIDIOC_QUERYMENU:
        return list_menu(data);
    case VIDIOC_G_CTRL:
        if (!control_of(((struct v4l2_control *)data)->id))
            return failed(EINVAL);
        ((struct v4l2_control *)data)->value = control_of(((struct v4l2_control *)data)->id)->value;
        return 0;
    case VIDIOC_S_CTRL:
        return set_control(data);
    case VIDIOC_REQBUFS:
        return is_busy ? failed(EBUSY) : 0;
    case VIDIOC_QUERYBUF:
        ((struct v4l2_buffer *)data)->length = BUFFER_BYTES;
        ((struct v4l2_buffer *)data)->m.offset = ((struct v4l2_buffer *)data)->index * BUFFER_BYTES;
        return 0;
    case VIDIOC_QBUF:
        return queue(of, data);
    case VIDIOC_STREAMON:
        return is_busy ? failed(EBUSY) : stream_on(fd);
    case VIDIOC_STREAMOFF:
        return stream_off(fd);
    case VIDIOC_DQBUF:
        return dequeue(fd, data);
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
    if (device_of(fd))
        return answer(fd, request & 0xffffffffUL, data);
    int (*real)(int, unsigned long, ...) = dlsym(RTLD_NEXT, "ioctl");
    return real(fd, request, data);
}
