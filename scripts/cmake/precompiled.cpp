// Empty: gives the headers that options.cmake has precompiled a target to belong to.
