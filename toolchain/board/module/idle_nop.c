// SPDX-License-Identifier: GPL-2.0
/*
 * An idle processor that executes instead of halting, for virtual time. Where a processor halts, qemu
 * skips the time to the next timer in another thread of its own, which may be a moment too early:
 * how much is skipped then depends on the machine. Instructions that do nothing pass time as well,
 * by 2 ns each, and hundreds of them cost the machine no more than one.
 */
#include <linux/cpuidle.h>
#include <linux/module.h>
#include <linux/sched/idle.h>

static int pass_time(struct cpuidle_device *device, struct cpuidle_driver *driver, int index)
{
	raw_local_irq_enable();
	if (!current_set_polling_and_test())
		while (!need_resched())
			asm volatile(".rept 480\n\tnop\n\t.endr" ::: "memory");
	raw_local_irq_disable();
	current_clr_polling();
	return index;
}

static struct cpuidle_driver idle_nop = {
	.name = "idle_nop",
	.owner = THIS_MODULE,
	.states = { { .name = "nop", .desc = "executes nothing", .enter = pass_time } },
	.state_count = 1,
};

static int __init enter(void)
{
	return cpuidle_register(&idle_nop, NULL);
}

static void __exit finish(void)
{
	cpuidle_unregister(&idle_nop);
}
module_init(enter);
module_exit(finish);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("idle time that is executed, for virtual time");
