/* Included by the build before the first line of every tests/ROOM/test_*.c. Such a file is an ordinary cmocka
 * program; a room's files are linked into one, in which the main of each has the name GROUP. */
#pragma once

#define GROUP_PICK(one, two, chosen, ...) chosen
#define GROUP_WITH_ARGUMENTS(count, arguments)                                                               \
    GROUP(int, char **);                                                                                     \
    int GROUP(count, arguments)
#define GROUP_WITHOUT(none)                                                                                  \
    GROUP(int, char **);                                                                                     \
    static int group_main(none);                                                                             \
    int GROUP(int count, char **arguments)                                                                   \
    {                                                                                                        \
        (void)count;                                                                                         \
        (void)arguments;                                                                                     \
        return group_main();                                                                                 \
    }                                                                                                        \
    static int group_main(none)
#define main(...) GROUP_PICK(__VA_ARGS__, GROUP_WITH_ARGUMENTS, GROUP_WITHOUT, )(__VA_ARGS__)
