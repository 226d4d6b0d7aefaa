"""What a haptic_server is run in to have fewer rights: a program in front of it, and a bus for the tests' RealtimeKit."""

# uid 0 stays, so that the session's folder does; what makes a process real-time goes.
WITHOUT_RIGHTS = ("prlimit", "--rtprio=0:0", "--memlock=65536:65536",
                  "setpriv", "--bounding-set=-sys_nice,-ipc_lock,-sys_resource")
_BUS = """<!DOCTYPE busconfig PUBLIC "-//freedesktop//DTD D-Bus Bus Configuration 1.0//EN"
 "http://www.freedesktop.org/standards/dbus/1.0/busconfig.dtd">
<busconfig><type>system</type><listen>unix:path={address}</listen><auth>EXTERNAL</auth>
<policy context="default"><allow user="*"/><allow own="*"/><allow send_type="method_call"/>
<allow send_destination="*"/><allow receive_sender="*"/></policy></busconfig>
"""


def bus_command(folder, address):
    """What starts a bus at that address, its configuration in folder."""
    configuration = folder / "bus.conf"
    configuration.write_text(_BUS.format(address=address))
    return "dbus-daemon", "--nofork", "--nopidfile", "--config-file", configuration
