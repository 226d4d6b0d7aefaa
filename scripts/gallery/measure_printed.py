#!/usr/bin/python3
"""Measures what a program of its own prints as a table, and writes it: docs/charts/TABLE.csv.

Nothing here but soft_meshes depends on a clock: the same build gives the same figures. ku_contact and
velocity need the folder of real inputs. soft_meshes takes ten minutes, velocity two, two_rate one, the others
seconds.
"""
from measuring import output_of, parser_of, program
from tables import write_text

PROGRAMS = {"row_ripple": "row_figures", "ku_contact": "contact_figures",
            "broyden_iterations": "broyden_figures", "velocity": "velocity_figures",
            "two_rate": "two_rate_figures", "soft_meshes": "soft_mesh_figures",
            "interface_energy": "interface_figures"}
CAN_BE_SMALL = ("velocity", "two_rate", "soft_meshes", "interface_energy")


def main():
    parser = parser_of(__doc__, "velocity: two motions of four; two_rate: two periods of six; "
                                "soft_meshes: the smallest, few steps; "
                                "interface_energy: 20 scenes of 200; others are small")
    parser.add_argument("table", choices=PROGRAMS, metavar="TABLE", help=", ".join(PROGRAMS))
    arguments = parser.parse_args()
    command = [program(arguments.build, PROGRAMS[arguments.table])]
    if arguments.small and arguments.table in CAN_BE_SMALL:
        command.append("--small")
    write_text(arguments.charts / f"{arguments.table}.csv", output_of(command))


if __name__ == "__main__":
    main()
