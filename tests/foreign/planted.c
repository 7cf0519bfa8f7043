/* An FMU of somebody else whose library acts as soon as it is loaded: it leaves a file that PLCFMU_MARK names, and crashes,
   hangs, leaves or goes on as PLCFMU_PLANT says. "fork" and "orphan" leave a process behind, whose number is in the file; it holds all that
   the FMU's process had open. With TABLE it claims to have been made by plcfmu. */

#include "faulty.c"

__attribute__((constructor)) static void planted(void) {
    volatile int for_ever = 1;
    const char *mark = getenv("PLCFMU_MARK"), *plant = getenv("PLCFMU_PLANT");
    FILE *file = mark ? fopen(mark, "a") : NULL;
    if (!plant) plant = "";
    if (!strcmp(plant, "fork") || !strcmp(plant, "orphan")) {
        pid_t child = fork();
        if (!child) while (for_ever) pause();
        if (file) fprintf(file, "%d\n", (int)child);
    }
    if (file) fclose(file);
    if (!strcmp(plant, "crash")) abort();
    if (!strcmp(plant, "hang")) while (for_ever) pause();
    if (!strcmp(plant, "orphan")) _exit(3);
}

#ifdef TABLE
size_t plcfmu_interface(char *json, size_t size) { return 0; }
#endif
