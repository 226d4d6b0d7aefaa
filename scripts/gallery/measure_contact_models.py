#!/usr/bin/python3
"""Measures all models of contact with a rigid mesh beside the exact mesh, with the program contact_model_figures:
docs/charts/contact_models.csv (error, time and memory; needs the folder of real inputs), contact_drawn.csv (a tool
drawn over a flat face) and contact_corner.csv (a rod in a corner)."""
from measuring import output_of, parser_of, program
from tables import write_text

TABLES = {"models": "contact_models", "drawn": "contact_drawn", "corner": "contact_corner"}


def main():
    arguments = parser_of(__doc__, "of the models one fineness each, on one mesh; the others are small").parse_args()
    for table, name in TABLES.items():
        command = [program(arguments.build, "contact_model_figures"), table]
        if arguments.small and table == "models":
            command.append("--small")
        write_text(arguments.charts / f"{name}.csv", output_of(command))


if __name__ == "__main__":
    main()
