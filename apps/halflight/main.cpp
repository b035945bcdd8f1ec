#include "program.h"

int main(int argc, char** argv)
{
    return halflight::cli::leavingWith(halflight::cli::runProgram(argc, argv));
}
