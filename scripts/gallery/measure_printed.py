#!/usr/bin/python3
"""Measures what a program of its own prints as a table, and writes it: docs/charts/TABLE.csv.

The same build gives the same figures, except for the times in voxel_ratio. interface_energy takes minutes, the others seconds.
"""
from measuring import output_of, parser_of, program
from tables import write_text

PROGRAMS = {"broyden_iterations": "broyden_figures", "voxel_ratio": "voxel_ratio_figures",
            "interface_energy": "interface_figures"}
CAN_BE_SMALL = ("interface_energy",)


def main():
    parser = parser_of(__doc__, "interface_energy: 20 scenes of 200; others are small")
    parser.add_argument("table", choices=PROGRAMS, metavar="TABLE", help=", ".join(PROGRAMS))
    arguments = parser.parse_args()
    command = [program(arguments.build, PROGRAMS[arguments.table])]
    if arguments.small and arguments.table in CAN_BE_SMALL:
        command.append("--small")
    write_text(arguments.charts / f"{arguments.table}.csv", output_of(command))


if __name__ == "__main__":
    main()
