"""Clearway on an arena PC: Debian with systemd on an emulated machine, with real drivers.

``make arena-pc`` builds the machine's disks and runs these tests. Each begins with a machine that
is restored from a snapshot; cameras and serial adapters are programs of the host, which the guest's
kernel takes for USB devices. An emulated machine is ten to thirty times slower than its host: what
is tested here is what the kernel, udev and systemd do with the program, never how fast it is.
"""
