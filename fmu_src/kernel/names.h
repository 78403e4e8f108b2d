/* By which names does a linker know what the C files share? By their own here. In the sources of an FMU this file puts
 * the FMU's name in front of each, so that nothing else in the same program has it: no other FMU, no library.
 */
