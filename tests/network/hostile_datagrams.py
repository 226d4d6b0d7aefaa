"""Sends what no relay sends to the relay on the other side, for relay_hostile_test: datagrams of random bytes and
lengths, and packets of this side's own relay with bytes changed, cut off, doubled, or put together anew.

hostile_datagrams.py ADDRESS SECONDS SEED   prints how many it sent, and how many of them were a relay's
"""
import random
import socket
import struct
import sys
import time

from two_machines import INTERFACE

ETH_P_IP = 0x0800
UDP = 17
HEADER = b"RTPS"
PORTS = range(7400, 7426)  # of the first participants of domain 0
AT_ONCE = 20
PAUSE_S = 0.002


def payload_of(packet):
    """The datagram and port in a whole IPv4 packet that bears RTPS, or None."""
    length = 4 * (packet[0] & 15)
    if packet[9] != UDP or struct.unpack_from(">H", packet, 6)[0] & 0x3fff:
        return None
    port = struct.unpack_from(">H", packet, length + 2)[0]
    data = packet[length + 8:]
    return (data, port) if data.startswith(HEADER) else None


def mutated(packets, draw):
    data = bytearray(draw.choice(packets))
    for _ in range(draw.choice((1, 1, 2, 5, 20))):
        at = draw.randrange(len(data))
        kind = draw.randrange(5)
        if kind == 0:
            data[at] ^= 1 << draw.randrange(8)
        elif kind == 1:
            data[at:at + 4] = draw.choice((b"\xff\xff\xff\xff", b"\0\0\0\0", b"\xff\xff\xff\x7f", draw.randbytes(4)))
        elif kind == 2:
            del data[max(20, at):]
        elif kind == 3:
            other = draw.choice(packets)
            data[at:] = other[draw.randrange(len(other)):]
        else:
            data[at:at] = draw.randbytes(draw.randrange(1, 64))
        data = data[:1472] or bytearray(HEADER)
    return bytes(data)


def main():
    address, seconds, draw = sys.argv[1], float(sys.argv[2]), random.Random(int(sys.argv[3]))
    listener = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(ETH_P_IP))
    listener.bind((INTERFACE, ETH_P_IP))
    listener.setblocking(False)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    packets, ports, sent, of_relay = [], set(), 0, 0
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        for _ in range(AT_ONCE):
            try:
                found = payload_of(listener.recv(65536))
            except BlockingIOError:
                break
            if found:
                packets.append(found[0])
                ports.add(found[1])
        del packets[:-400]
        for _ in range(AT_ONCE):
            if packets and draw.random() < 0.8:
                data = mutated(packets, draw)
                port = draw.choice(sorted(ports))
                of_relay += 1
            else:
                data = draw.choice((b"", HEADER)) + draw.randbytes(draw.choice((0, 1, 4, 20, 64, 500, 1400)))
                port = draw.choice(PORTS)
            try:
                sender.sendto(data, (address, port))
                sent += 1
            except OSError:  # nobody has that port: told by the packet before
                pass
        time.sleep(PAUSE_S)
    print(sent, of_relay)


if __name__ == "__main__":
    main()
