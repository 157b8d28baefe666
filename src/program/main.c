/* mbsrank: models from files on the command line.
 * SPDX-License-Identifier: BSD-3-Clause */
#include "program/program.h"

#include <string.h>

typedef struct command {
    const char *name, *line, *help;
    int (*run)(int argc, char **argv);
} command;

#define COMMON                                                                                     \
    "  --start NAME   start from this key of the file, not as drawn\n"                             \
    "  --floating     URDF: the root link is free\n"                                               \
    "  --package NAME=DIR   where package://NAME/, model://NAME/, $(find NAME) are; repeatable\n"  \
    "  --arg NAME=VALUE     xacro: the value of $(arg NAME); may be repeated\n"                    \
    "  --folder DIR   where files that the model names may be, beside its own folder and\n"        \
    "                 ../meshes; may be repeated; --anywhere: in any folder\n"                     \
    "  --stop-stiffness K, --stop-damping D   limits of joints as such stops, N/m or N m/rad\n"    \
    "  --slip V       dry friction of joints, smooth below this rate, m/s or rad/s\n"              \
    "  --no-limits, --no-friction   run, view: none of them unless these ask for them; else\n"     \
    "                 stops and friction are by the masses and ranges of the joints\n"             \
    "  --set NAME=VALUE   a parameter as info --parameters calls it; more than once: more\n"       \
    "  --no-contacts  shapes for contact of the file do not touch\n"                               \
    "  --strict       refuse files with findings\n"

static const command commands[] = {
    {"info", "what a model consists of",
     "usage: mbsrank info FILE [options]\n"
     "Writes the tree of bodies with their joints, masses, actuators, keys and findings.\n"
     "  --parameters   in their place the parameters, their values and units\n"
     "  --json         for a script to read\n" COMMON,
     run_info},
    {"check", "index and ranks at the start; exit 1 when something is undetermined",
     "usage: mbsrank check FILE [options]\n"
     "Says which directions have mass and which damping, springs or nothing determines.\n"
     "  --small        also which small masses may be zero, by a run from the start\n"
     "  --time T       s, of that run; default 1\n"
     "  --tolerance E  what error is allowed then in joint coordinates; default 1e-3\n"
     "  --json         for a script to read\n" COMMON,
     run_check},
#if defined(MBSR_WITH_IDA)
    {"run", "integrate from the start and write CSV or HDF5",
     "usage: mbsrank run FILE --t-end T [options]\n"
     "  --t-end T      end, s\n"
     "  --step H       from output to output, s; default T / 100\n"
     "  --rtol R, --atol A   tolerances, default 1e-6\n"
     "  --form F       momentum (default) or index1\n"
     "  --inputs FILE  t and names of actuators; each line holds from its time on\n"
     "  --output NAMES between commas: JOINT, JOINT.rate, BODY.pos, SENSOR, energy, state (all\n"
     "                 joints and rates), BODY.contact, BODY:BODY.contact, contacts; default all "
     "joints\n"
     "  -o FILE        instead of standard output; ending in .h5 or .hdf5: HDF5\n"
     "  --json         with -o: how it ended and what it cost, for a script to read\n"
     "  --quiet        neither progress nor findings\n" COMMON,
     run_run},
#endif
#if defined(MBSR_WITH_STUDY)
    {"study", "many runs with other values of parameters",
     "usage: mbsrank study FILE [options]\n"
     "FILE says what is varied and kept (docs/study.md). Given again after it was stopped or\n"
     "killed, the command goes on where it was.\n"
     "  -o RESULT      HDF5 by the ending .h5 or .hdf5, else CSV; default NAME.h5 here for\n"
     "                 NAME.study; RESULT.runs is a folder with what has been done\n"
     "  --jobs N       processes, default 1; or mpirun -n P mbsrank study ...\n"
     "  --anew         forget what has been done\n"
     "  --json         statistics for a script to read\n"
     "  --quiet        neither progress nor findings\n",
     run_study},
    {"fit", "parameters from measured data",
     "usage: mbsrank fit FILE --data DATA --vary NAME [options]\n"
     "  --data DATA    CSV or HDF5: t and columns of mbsrank run, as they were measured\n"
     "  --vary NAME, NAME=LOW:HIGH   a parameter that is looked for, from its value in FILE (or "
     "of\n"
     "                 --set) on, between bounds; more than once: more\n"
     "  --noise COLUMN=S   deviation of its noise; default: that of the residuals\n"
     "  -o RUN         CSV: what was measured, and what the model gives\n"
     "  --json         for a script to read\n"
     "  --rtol R, --atol A, --form F, --inputs FILE   as of run; default 1e-8 and 1e-9\n" COMMON,
     run_fit},
#endif
#if defined(MBSR_WITH_FMU)
    {"fmu", "write a Functional Mock-up Unit for other simulators",
     "usage: mbsrank fmu FILE -o UNIT [options]\n"
     "  -o UNIT        ending in .fmu\n"
     "  --fmi V        version of the standard, 2 or 3; default 3\n"
     "  --kind K       cs (co-simulation), me (model exchange), both; default: what is possible\n"
     "  --fixed-step H   co-simulation by steps of bounded cost, at most H s long\n"
     "  --sources      C11 sources too, to be compiled elsewhere\n"
     "  --order N      of these, 1 or 2 (default)\n"
     "  --rtol R, --atol A   tolerances of co-simulation, default 1e-6\n"
     "  --t-end T, --step H   default experiment, s; default 1 and 1e-3\n"
     "  --name NAME    of the model, not that of the file\n" COMMON,
     run_fmu},
#endif
#if defined(MBSR_WITH_LINEAR)
    {"static", "where a model rests",
     "usage: mbsrank static FILE [options]\n"
     "Finds the equilibrium that the model comes to rest in from the start, motors off.\n"
     "  --trim NAMES   frees these parameters, between commas; also finds unstable rests\n"
     "  --hold JOINTS  keeps these where they start; all: every one\n"
     "  --json         for a script to read\n" COMMON,
     run_static},
    {"modes", "natural frequencies, damping and shapes",
     "usage: mbsrank modes FILE [options]\n"
     "About the equilibrium that static finds, massless bodies and loops included.\n"
     "  --count N      the N slowest alone, also of large models\n"
     "  --mode K -o RUN    the motion of mode K of the list, for mbsrank view\n"
     "  --as-drawn     about the start, not about an equilibrium\n"
     "  --json         for a script to read\n" COMMON,
     run_modes},
    {"linearise", "matrices of the linear equations of motion",
     "usage: mbsrank linearise FILE [options]\n"
     "z' = A z + B w, y = C z + D w with the least number of states, row by row as CSV.\n"
     "  --inputs NAMES     between commas: forces of joints, parameters, motions by name\n"
     "  --outputs NAMES    joints, bodies.NAME.q, .u, .x, .y, .z, forces.NAME.f[k], .tau[k]\n"
     "  -o FILE            all matrices in a file: .mat for MATLAB, Octave, SciPy; .h5; .csv\n"
     "  --response FROM:TO:COUNT   frequency response in Hz, as CSV, in place of matrices\n"
     "  --as-drawn     about the start, not about an equilibrium\n"
     "  --json         for a script to read\n" COMMON,
     run_linearise},
#endif
    {"plot", "draw columns of a run by gnuplot",
     "usage: mbsrank plot RUN -o PICTURE [options]\n"
     "RUN is that of mbsrank run, or results of mbsrank study: envelopes and histograms.\n"
     "  -o PICTURE       ending in .png or .svg\n"
     "  --columns NAMES  by commas, panels by colons; hand.pos: hand.pos.*; default all\n"
     "  --over NAME      of a study: all columns over this parameter\n"
     "  --title TEXT     above\n",
     run_plot},
    {"view", "write a page that shows a model, and a run of it",
     "usage: mbsrank view FILE [RUN] [--live] [-o PAGE] [options]\n"
     "The page is one file, which any browser opens: the model in 3-D, moving as in RUN, of\n"
     "mbsrank run with all joints; with their rates (--output state) also the joint reactions.\n"
     "Without RUN sliders move the joints.\n"
     "  --live         the page runs the model: pull bodies, change parameters by sliders\n"
     "  -o PAGE        where to; - is standard output; default: NAME.html here for NAME.urdf\n"
     "  --inputs FILE  of the run, for the reactions\n" COMMON,
     run_view},
    {"convert", "write a model as MJCF",
     "usage: mbsrank convert FILE TO [options]\n"
     "TO becomes MJCF, read again a model with the same accelerations; - is standard output. What\n"
     "MJCF cannot say, or MuJoCo does not take, goes to standard error.\n"
     "  --floating     URDF: the root link is free\n"
     "  --package NAME=DIR   where package://NAME/, model://NAME/, $(find NAME) are; repeatable\n"
     "  --arg NAME=VALUE     xacro: the value of $(arg NAME); may be repeated\n"
     "  --folder DIR, --anywhere   where files that the model names may be\n"
     "  --strict       refuse files with findings, of reading or writing\n",
     run_convert},
};
enum { COMMANDS = sizeof commands / sizeof *commands };

static void print_help(FILE *to)
{
    fputs(
        "usage: mbsrank COMMAND FILE [options]\n"
        "Models of URDF, xacro, MJCF and SDF: trees of bodies, of which some may have no mass.\n\n",
        to);
    for (int k = 0; k < COMMANDS; ++k)
        fprintf(to, "  %-9s %s\n", commands[k].name, commands[k].line);
    fputs("\nmbsrank COMMAND --help tells the options of each. The file - is standard input.\n"
          "Exit: 0 done, 1 undetermined (check), 2 wrong use, 3 a file cannot be read, 4 failed.\n",
          to);
}

/* The command that the arguments name. */
static int do_command(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "";
    if (strcmp(name, "--version") == 0) {
        printf("mbsrank %s\n", mbsr_version());
        return DONE;
    }
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        print_help(stdout);
        return DONE;
    }
    for (int k = 0; k < COMMANDS; ++k) {
        if (strcmp(name, commands[k].name) != 0) continue;
        for (int l = 2; l < argc; ++l) {
            if (strcmp(argv[l], "--help") != 0 && strcmp(argv[l], "-h") != 0) continue;
            fputs(commands[k].help, stdout);
            return DONE;
        }
        return commands[k].run(argc - 2, argv + 2);
    }
    if (*name) return complain(USAGE, "there is no command '%s'; mbsrank --help", name);
    print_help(stderr);
    return USAGE;
}

int main(int argc, char **argv)
{
    const int code = do_command(argc, argv);
    const bool bad = fflush(stdout) != 0 || ferror(stdout);
    return code <= UNDETERMINED && bad ? complain(FAILED, "the output cannot be written") : code;
}
