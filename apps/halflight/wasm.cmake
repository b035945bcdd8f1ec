# The module that web/cli and web/bake load, in Node.js and in browsers: halflight.mjs and halflight.wasm.
set_target_properties(halflight PROPERTIES SUFFIX .mjs)
target_link_options(halflight PRIVATE
    -sMODULARIZE=1 -sEXPORT_ES6=1 -sENVIRONMENT=node,web,worker -sINVOKE_RUN=0
    # Files: in memory, and in Node those of the machine.
    -sFORCE_FILESYSTEM=1 -lnodefs.js -sEXPORTED_RUNTIME_METHODS=FS,callMain
    -sEXPORTED_FUNCTIONS=_main,_halflightState,_halflightCancelRequested,_halflightTemporaryFile
    # All memory that 32 bits address. mimalloc, since threads wait for one another in the others.
    -sALLOW_MEMORY_GROWTH=1 -sINITIAL_MEMORY=64MB -sMAXIMUM_MEMORY=4GB -sMALLOC=mimalloc
    # A bake's tasks recurse; dependencies.sh gives oneTBB's workers as much.
    -sSTACK_SIZE=4MB -sDEFAULT_PTHREAD_STACK_SIZE=4MB
    # Threads are there before main(), which answers nobody while it runs; the loader says how many.
    -sPTHREAD_POOL_SIZE=Module.threads)
# The command line takes no time worth mentioning, reading and writing files little, and both room in what is downloaded.
foreach(part halflight halflight_cli halflight_scene)
    target_compile_options(${part} PRIVATE -Os)
endforeach()
