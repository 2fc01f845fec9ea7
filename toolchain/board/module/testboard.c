// SPDX-License-Identifier: GPL-2.0
/*
 * The silicon of a board for tests: what a program sets is what the kernel's IIO core samples, and
 * what the kernel's PWM and GPIO cores are told is what a program reads. README.md says how.
 */
#include <linux/bitops.h>
#include <linux/gpio/driver.h>
#include <linux/iio/buffer.h>
#include <linux/iio/iio.h>
#include <linux/iio/trigger_consumer.h>
#include <linux/iio/triggered_buffer.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/pwm.h>
#include <linux/uaccess.h>

#define CHANNELS 8
#define LINES 2 /* enable, kick */

static unsigned int oneshot_us = 8000;
module_param(oneshot_us, uint, 0444);
MODULE_PARM_DESC(oneshot_us, "the output is cut so long after the last edge of the kick line; 0: never");

/* What a program of the test writes to and reads from /dev/testboard. */
struct board_codes {
	s32 code[CHANNELS];
};
struct board_output {
	u64 now_ns;	  /* CLOCK_MONOTONIC, as all times here */
	u64 period_ns;
	u64 duty_ns;	  /* as the PWM's user has set it */
	u64 effective_ns; /* the duty that gets through: 0 without enable, kick or a PWM */
	u64 changed_ns;	  /* since when it is zero, or is not */
	u64 kicked_ns;	  /* last edge of the kick line */
	u64 cuts;	  /* how often the one-shot has ended heat */
};

static struct {
	spinlock_t lock; /* all of this */
	s32 code[CHANNELS];
	int fault[CHANNELS];
	bool pwm_on, line[LINES], heats;
	u64 period_ns, duty_ns, changed_ns, kicked_ns, cuts;
} board = { .lock = __SPIN_LOCK_UNLOCKED(board.lock) };

/* What the one-shot has done up to now, then what is on from now. Under the lock. */
static void settle(u64 now)
{
	u64 end = board.kicked_ns + 1000ull * oneshot_us;
	bool alive = !oneshot_us || now < end;
	bool heats = board.pwm_on && board.duty_ns && board.line[0] && alive;

	if (board.heats == heats)
		return;
	if (!alive && board.pwm_on && board.duty_ns && board.line[0])
		board.cuts++;
	board.changed_ns = board.heats && !alive ? end : now;
	board.heats = heats;
}

/* ---- ADC: a scan of channels in as many formats as real converters have ---- */

static ssize_t setting_get(struct iio_dev *d, uintptr_t fault, const struct iio_chan_spec *c, char *out)
{
	return sysfs_emit(out, "%d\n", fault ? READ_ONCE(board.fault[c->channel]) : READ_ONCE(board.code[c->channel]));
}

static ssize_t setting_set(struct iio_dev *d, uintptr_t fault, const struct iio_chan_spec *c, const char *in, size_t n)
{
	int value, r = kstrtoint(in, 0, &value);

	if (r)
		return r;
	WRITE_ONCE(*(fault ? &board.fault[c->channel] : &board.code[c->channel]), value);
	return n;
}

static const struct iio_chan_spec_ext_info settings[] = {
	{ .name = "code", .shared = IIO_SEPARATE, .read = setting_get, .write = setting_set, .private = 0 },
	{ .name = "fault", .shared = IIO_SEPARATE, .read = setting_get, .write = setting_set, .private = 1 },
	{}
};

#define CHANNEL(i, s, bits, storage, right, order)                                                   \
	{                                                                                            \
		.type = IIO_VOLTAGE, .indexed = 1, .channel = i, .scan_index = i, .ext_info = settings, \
		.info_mask_separate = BIT(IIO_CHAN_INFO_RAW) | BIT(IIO_CHAN_INFO_SCALE),               \
		.scan_type = { .sign = s, .realbits = bits, .storagebits = storage, .shift = right,    \
			       .endianness = order },                                                  \
	}
static const struct iio_chan_spec channels[] = {
	CHANNEL(0, 's', 24, 32, 8, IIO_BE),  CHANNEL(1, 's', 24, 32, 0, IIO_LE),
	CHANNEL(2, 's', 24, 32, 8, IIO_LE),  CHANNEL(3, 'u', 12, 16, 4, IIO_BE),
	CHANNEL(4, 'u', 12, 16, 0, IIO_CPU), CHANNEL(5, 's', 16, 16, 0, IIO_BE),
	CHANNEL(6, 'u', 8, 8, 0, IIO_CPU),   CHANNEL(7, 's', 32, 32, 0, IIO_BE),
	IIO_CHAN_SOFT_TIMESTAMP(CHANNELS),
};

static int read_one(struct iio_dev *d, const struct iio_chan_spec *c, int *value, int *value2, long what)
{
	int fault = READ_ONCE(board.fault[c->channel]);

	switch (what) {
	case IIO_CHAN_INFO_RAW:
		*value = READ_ONCE(board.code[c->channel]);
		return fault ? -fault : IIO_VAL_INT;
	case IIO_CHAN_INFO_SCALE: /* 2.5 V, in mV per code */
		*value = 2500;
		*value2 = c->scan_type.realbits - (c->scan_type.sign == 's');
		return IIO_VAL_FRACTIONAL_LOG2;
	}
	return -EINVAL;
}
static const struct iio_info adc_info = { .read_raw = read_one };

static size_t put(u8 *scan, size_t at, const struct iio_scan_type *t, s32 code)
{
	u32 word = ((u32)code & GENMASK(t->realbits - 1, 0)) << t->shift;
	size_t size = t->storagebits / 8, i;
	bool big = t->endianness == IIO_BE;

	at = ALIGN(at, size);
	for (i = 0; i < size; i++)
		scan[at + (big ? size - 1 - i : i)] = word >> (8 * i);
	return at + size;
}

/* One coherent scan; a channel that cannot be read loses the whole of it, as drivers do. */
static irqreturn_t capture(int irq, void *p)
{
	struct iio_poll_func *poll = p;
	struct iio_dev *d = poll->indio_dev;
	u8 scan[64] __aligned(8) = {};
	s32 code[CHANNELS];
	unsigned long flags;
	bool failed = false;
	size_t at = 0;
	int i;

	spin_lock_irqsave(&board.lock, flags);
	memcpy(code, board.code, sizeof(code));
	iio_for_each_active_channel(d, i)
		failed |= i < CHANNELS && board.fault[i];
	spin_unlock_irqrestore(&board.lock, flags);
	iio_for_each_active_channel(d, i)
		if (i < CHANNELS)
			at = put(scan, at, &channels[i].scan_type, code[i]);
	if (!failed)
		iio_push_to_buffers_with_timestamp(d, scan, poll->timestamp);
	iio_trigger_notify_done(d->trig);
	return IRQ_HANDLED;
}

static int adc_probe(struct platform_device *p)
{
	struct iio_dev *d = devm_iio_device_alloc(&p->dev, 0);
	int r;

	if (!d)
		return -ENOMEM;
	d->name = "testboard";
	d->modes = INDIO_DIRECT_MODE;
	d->info = &adc_info;
	d->channels = channels;
	d->num_channels = ARRAY_SIZE(channels);
	r = devm_iio_triggered_buffer_setup(&p->dev, d, iio_pollfunc_store_time, capture, NULL);
	return r ?: devm_iio_device_register(&p->dev, d);
}

/* ---- drive: PWM, enable line, kick line ---- */

static int pwm_set(struct pwm_chip *c, struct pwm_device *p, const struct pwm_state *s)
{
	unsigned long flags;

	spin_lock_irqsave(&board.lock, flags);
	settle(ktime_get_ns());
	board.pwm_on = s->enabled;
	board.period_ns = s->period;
	board.duty_ns = s->duty_cycle;
	settle(ktime_get_ns());
	spin_unlock_irqrestore(&board.lock, flags);
	return 0;
}
static const struct pwm_ops pwm_ops = { .apply = pwm_set };

static void line_set(struct gpio_chip *c, unsigned int n, int value)
{
	unsigned long flags;
	u64 now;

	spin_lock_irqsave(&board.lock, flags);
	now = ktime_get_ns();
	settle(now);
	if (n == 1 && board.line[1] != !!value)
		board.kicked_ns = now;
	board.line[n] = value;
	settle(now);
	spin_unlock_irqrestore(&board.lock, flags);
}

static int line_get(struct gpio_chip *c, unsigned int n)
{
	return READ_ONCE(board.line[n]);
}

static int line_out(struct gpio_chip *c, unsigned int n, int value)
{
	line_set(c, n, value);
	return 0;
}

static int line_direction(struct gpio_chip *c, unsigned int n)
{
	return GPIO_LINE_DIRECTION_OUT;
}

static void heat_off(void *unused)
{
	pwm_set(NULL, NULL, &(struct pwm_state){});
}

static int drive_probe(struct platform_device *p)
{
	static const char *const names[LINES] = { "heat-enable", "heat-kick" };
	struct gpio_chip *g = devm_kzalloc(&p->dev, sizeof(*g), GFP_KERNEL);
	struct pwm_chip *c = devm_pwmchip_alloc(&p->dev, 1, 0);
	int r;

	if (!g)
		return -ENOMEM;
	if (IS_ERR(c))
		return PTR_ERR(c);
	*g = (struct gpio_chip){ .label = "testboard", .parent = &p->dev, .owner = THIS_MODULE, .base = -1,
				 .ngpio = LINES, .names = names, .get_direction = line_direction,
				 .direction_output = line_out, .get = line_get, .set = line_set };
	r = devm_gpiochip_add_data(&p->dev, g, NULL);
	if (r)
		return r;
	c->ops = &pwm_ops;
	r = devm_pwmchip_add(&p->dev, c);
	return r ?: devm_add_action(&p->dev, heat_off, NULL);
}

/* ---- /dev/testboard: the plant's side ---- */

static ssize_t plant_write(struct file *f, const char __user *in, size_t n, loff_t *at)
{
	struct board_codes codes;
	unsigned long flags;

	if (n != sizeof(codes))
		return -EINVAL;
	if (copy_from_user(&codes, in, n))
		return -EFAULT;
	spin_lock_irqsave(&board.lock, flags);
	memcpy(board.code, codes.code, sizeof(board.code));
	spin_unlock_irqrestore(&board.lock, flags);
	return n;
}

static ssize_t plant_read(struct file *f, char __user *out, size_t n, loff_t *at)
{
	struct board_output o;
	unsigned long flags;

	if (n != sizeof(o))
		return -EINVAL;
	spin_lock_irqsave(&board.lock, flags);
	o.now_ns = ktime_get_ns();
	settle(o.now_ns);
	o.period_ns = board.period_ns;
	o.duty_ns = board.duty_ns;
	o.effective_ns = board.heats ? board.duty_ns : 0;
	o.changed_ns = board.changed_ns;
	o.kicked_ns = board.kicked_ns;
	o.cuts = board.cuts;
	spin_unlock_irqrestore(&board.lock, flags);
	return copy_to_user(out, &o, sizeof(o)) ? -EFAULT : n;
}
static const struct file_operations plant_files = { .owner = THIS_MODULE, .read = plant_read, .write = plant_write };
static struct miscdevice plant = { .minor = MISC_DYNAMIC_MINOR, .name = "testboard", .fops = &plant_files };

static struct platform_driver drivers[] = {
	{ .probe = adc_probe, .driver = { .name = "testboard-adc" } },
	{ .probe = drive_probe, .driver = { .name = "testboard-drive" } },
};
static struct platform_device *devices[ARRAY_SIZE(drivers)];

static void leave(int n)
{
	while (n--) {
		platform_device_unregister(devices[n]);
		platform_driver_unregister(&drivers[n]);
	}
	misc_deregister(&plant);
}

static int __init enter(void)
{
	int r = misc_register(&plant), i;

	if (r)
		return r;
	for (i = 0; i < ARRAY_SIZE(drivers); i++) {
		r = platform_driver_register(&drivers[i]);
		if (!r) {
			devices[i] = platform_device_register_simple(drivers[i].driver.name, -1, NULL, 0);
			r = PTR_ERR_OR_ZERO(devices[i]);
			if (r)
				platform_driver_unregister(&drivers[i]);
		}
		if (r) {
			leave(i);
			return r;
		}
	}
	return 0;
}

static void __exit finish(void)
{
	leave(ARRAY_SIZE(drivers));
}
module_init(enter);
module_exit(finish);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("a board's ADC, PWM and GPIO for tests");
