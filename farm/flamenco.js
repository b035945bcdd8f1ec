// Job type for Flamenco 3: bakes a plan of `halflight farm plan`. Copy it into the Manager's `scripts` folder.
// Written from Flamenco's documentation of job types; not run against a Manager.

const JOB_TYPE = {
    label: "Halflight bake",
    settings: [
        { key: "plan", type: "string", subtype: "dir_path", required: true, description: "the plan's folder" },
        { key: "output", type: "string", subtype: "file_path", required: true, description: "the baked file to write" },
        { key: "workers", type: "int32", default: 16, description: "number of tasks of each stage" },
        { key: "program", type: "string", default: "halflight", visible: "submission" },
    ],
};

function task(job, name, args) {
    const made = author.Task(name, "misc");
    made.addCommand(author.Command("exec", { exe: job.settings.program, args: ["farm", ...args, "--quiet"] }));
    return made;
}

function compileJob(job) {
    const settings = job.settings;
    const of = String(settings.workers);
    const stageOf = (stage) => {
        const tasks = [];
        for (let index = 0; index < settings.workers; ++index)
            tasks.push(task(job, `${stage}-${index}`,
                ["work", settings.plan, "--index", String(index), "--of", of, "--stage", stage]));
        return tasks;
    };
    const cache = stageOf("cache");
    const tiles = stageOf("tiles");
    const join = task(job, "join", ["join", settings.plan, "-o", settings.output, "--of", of]);
    for (const tile of tiles) {
        for (const part of cache) tile.addDependency(part);
        join.addDependency(tile);
    }
    for (const each of [...cache, ...tiles, join]) job.addTask(each);
}
