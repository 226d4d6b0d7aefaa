"""Datagrams with numbers, for two_machines_test: what arrives, when, how often.

udp_echo.py receive PORT             echoes to the sender, prints the number of each and whether it is whole
udp_echo.py send ADDRESS PORT COUNT SPACING_S
                                     prints number and time there and back, s, until none comes for 0.3 s
udp_echo.py listen GROUP PORT        joins the multicast group, prints the first datagram
udp_echo.py cast GROUP PORT TEXT     sends it to the group
"""
import fcntl
import socket
import struct
import sys
import time

from two_machines import INTERFACE, PATIENCE

SIOCGIFFLAGS, IFF_MULTICAST = 0x8913, 0x1000  # linux/sockios.h, linux/if.h
QUIET_S = 0.3 * PATIENCE
PADDING = bytes(range(200))


def receive(port):
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    own.bind(("", int(port)))
    print("ready", flush=True)
    while True:
        packet, sender = own.recvfrom(2048)
        print(struct.unpack_from("!Q", packet)[0], int(packet[16:] == PADDING), flush=True)
        own.sendto(packet, sender)


def send(address, port, count, spacing_s):
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    own.connect((address, int(port)))
    own.setblocking(False)
    quiet_s, number, next_s = time.monotonic() + QUIET_S, 0, time.monotonic()
    while number < int(count) or time.monotonic() < quiet_s:
        now_s = time.monotonic()
        if number < int(count) and now_s >= next_s:
            own.send(struct.pack("!Qd", number, now_s) + PADDING)
            number, next_s, quiet_s = number + 1, now_s + float(spacing_s), now_s + QUIET_S
        try:
            number_back, sent_s = struct.unpack_from("!Qd", own.recv(2048))
            print(number_back, time.monotonic() - sent_s)
            quiet_s = time.monotonic() + QUIET_S
        except BlockingIOError:
            time.sleep(0.0001)


def listen(group, port):
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    own.bind(("", int(port)))
    here = socket.if_nametoindex(INTERFACE)
    own.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                   struct.pack("4s4si", socket.inet_aton(group), socket.inet_aton("0.0.0.0"), here))
    request = fcntl.ioctl(own, SIOCGIFFLAGS, struct.pack("16sH14x", INTERFACE.encode(), 0))
    if not struct.unpack("16sH14x", request)[1] & IFF_MULTICAST:
        sys.exit(f"{INTERFACE}: says that it has no multicast, so that middleware would not try")
    print("ready", flush=True)
    print(own.recv(2048).decode(), flush=True)


def cast(group, port, text):
    own = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    here = socket.if_nametoindex(INTERFACE)
    own.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF,
                   struct.pack("4s4si", bytes(4), socket.inet_aton("0.0.0.0"), here))
    own.sendto(text.encode(), (group, int(port)))


if __name__ == "__main__":
    {"receive": receive, "send": send, "listen": listen, "cast": cast}[sys.argv[1]](*sys.argv[2:])
