// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Options of the commands that run a scene or measure.

#include "commands.h"
#include "common_options.h"

namespace pliant::app {

void add_serve(CLI::App& app, ServeOptions& o) {
    auto* c = app.add_subcommand("serve", "Fly and push in the browser, alone or together");
    c->add_option("FILE", o.file,
                  "a scan as of info, the scene of a vessel or of organs (TOML), or an organ (VTU, "
                  "VTP, VTK, MSH, STL, OBJ, PLY: tetrahedra, or a closed surface) "
                  "(default: the airway phantom)");
    add_scan(c, o.scan);
    add_units(c, o.units);
    c->add_option("--labels", o.labels,
                  "label map that is drawn over the scan and moves with the tissue; colours are "
                  "those of 3D Slicer's segments (.seg.nrrd). With --config also the labels of its "
                  "[[label]] tables");
    add_label_names(c, o.label_names);
    c->add_option("--model", o.model,
                  "tissue at first, which the page may change: chainmail, elastic, springs, or "
                  "auto (default): elastic if it makes 25 pictures a second here, else chainmail, "
                  "also if --config has its tables; scenes and meshes have their own")
        ->check(CLI::IsMember({"auto", "chainmail", "elastic", "springs"}));
    c->add_option("--config", o.config,
                  "settings of ChainMail and the elastic scan, TOML, as of pliant deform");
    add_body_labels(c, o.bodies);
    c->add_option("--directions", o.directions,
                  "field of directions for the [[label]] tables of --config");
    c->add_option(
        "--network", o.network,
        "springs of pliant fit --network-out, which move the scan or the organ instead of "
        "its own model");
    c->add_option("--load-state", o.load_state,
                  "begin with a saved state of the tissue (.plst), as pliant deform and the page "
                  "save it");
    c->add_option_function<int>(
         "--port",
         [&o](int port) {
             o.port = port;
             o.port_given = true;
         },
         "port on this machine; 0: any free one (default 8765, or any free one)")
        ->check(CLI::Range(0, 65535));
    const char* const network = "For other machines (docs/howto/classroom.md)";
    c->add_option("--host", o.host,
                  "address to listen on (default 127.0.0.1: this machine only); 0.0.0.0: the "
                  "network too, with a certificate")
        ->group(network);
    c->add_option("--certificate", o.certificate, "PEM file, with the certificates that sign it")
        ->group(network);
    c->add_option("--key", o.key, "PEM file with its private key")->group(network);
    c->add_option("--url", o.url, "address of the page if a proxy stands in front of the server")
        ->group(network);
    c->add_option("--embed-in", o.embed_in,
                  "origin whose pages may show this one in a frame, such as a notebook's: "
                  "http://localhost:8888, or http://localhost:* for any port. May be repeated")
        ->group(network);
    c->add_option("--session", o.session,
                  "record the session in this file, or continue it. Scans that are opened in the "
                  "page are kept beside it, in SESSION.scans");
    c->add_option("--replay", o.replay,
                  "watch this session instead of a live scene: a time line, any speed, any camera");
    c->add_option("--checkpoint", o.checkpoint_s,
                  "with a session: save its state after each S seconds of work, which bounds the "
                  "time to open it (default 30)")
        ->check(CLI::Range(0.0, 1e6));
    c->add_option("--spring-nodes", o.spring_nodes,
                  "control nodes along an axis that a client may choose for springs (default 32); "
                  "with 64 a push may hold up everybody for a second")
        ->check(CLI::Range(3, 64));
    c->add_option("--network-hz", o.network_hz,
                  "updates per second that the automatic depth of springs leaves to the slowest "
                  "client (default 25); 0: slow lines don't lower it")
        ->check(CLI::Range(0, 1000));
    c->add_flag("--no-open", o.no_open, "print the link only");
    c->add_option("--haptics", o.haptics,
                  "a device with force feedback that the page may choose, as pliant haptics check "
                  "--device has it: a plug-in's file with :WHICH, or replay:FILE. May be repeated");
    add_threads(c, o.threads);
    c->footer(
        "Other scans are opened, and the deformed one is saved, in the page.\n"
        "Examples:\n  pliant serve scan.nrrd --session scan.pls\n  pliant serve "
        "scan.nrrd --model elastic --config moduli.toml\n  pliant serve "
        "scan.nrrd --labels organs.seg.nrrd\n  pliant serve "
        "scenes/vessel_phantom.toml\n  pliant serve liver.stl\n  pliant serve abdomen.nii.gz "
        "--labels organs.nii.gz --bodies\n  pliant serve organ.vtu --network fit.json\n  pliant "
        "serve scan.nrrd --host 0.0.0.0 --certificate "
        "class.pem --key class.key");
}

void add_replay(CLI::App& app, ReplayOptions& o) {
    auto* c = app.add_subcommand("replay", "Do a recorded session again, and compare the results");
    c->add_option("SESSION", o.session, "file of pliant serve --session")->required();
    c->add_flag("--from-checkpoint", o.from_checkpoint,
                "start from the checkpoint before the last, as pliant serve does");
    c->add_option("--out", o.out, "scan as the session left it (.nrrd, .mha, .nii.gz, .vti …)");
    c->add_option("--displacement", o.displacement, "forward displacement field (NRRD, LPS mm)");
    c->add_option("--transform", o.transform, "inverse: a grid transform of 3D Slicer (NRRD)");
    c->add_option("--save-state", o.save_state, "state of the tissue (.plst)");
    add_picture(c, o.picture, "towards the middle of the deformation");
    c->add_flag("--json", o.json, "one JSON object");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant replay scan.pls\n"
        "  pliant replay scan.pls --out pushed.nrrd --displacement moved.nrrd\n"
        "  pliant replay scan.pls --png left.png --style real");
}

void add_bench(CLI::App& app, BenchOptions& o) {
    auto* c = app.add_subcommand("bench",
                                 "Compare the solvers of ChainMail: time, and whether they agree");
    c->add_option("WHAT", o.what, "chainmail")->required()->check(CLI::IsMember({"chainmail"}));
    c->add_flag("--compare", o.compare,
                "the sweep with the heap and with the sweep without vector instructions");
    c->add_flag("--json", o.json, "one JSON object per case and solver, one on each line");
    c->add_option("--size", o.size, "elements along each edge (default 50)")
        ->check(CLI::Range(3, 400));
    c->add_option("--pull", o.pull_voxels, "length of the push [voxels] (default 5)")
        ->check(CLI::Range(0.01, 400.0));
    c->add_option("--grab", o.grab, "element (in the middle of a face), or cell (eight inside)")
        ->check(CLI::IsMember({"element", "cell"}));
    c->add_flag("--homogeneous", o.homogeneous, "only the case of one material");
    c->add_flag("--heterogeneous", o.heterogeneous, "only the case of four materials");
    c->add_option("--shear", o.shear_ratio, "shear / stretch of the four (default 0.5)")
        ->check(CLI::Range(0.0, 2.0));
    c->add_option("--rounds", o.rounds, "how often each is timed, turn by turn (default 9)")
        ->check(CLI::Range(1, 1000));
    c->add_option("--threads", o.threads, "threads of the sweeps (default 1; 0: all)")
        ->check(CLI::Range(0, 256));
    c->footer("Example:\n  pliant bench chainmail --compare --size 64 --pull 4 --heterogeneous");
}

void add_vessel(CLI::App& app, VesselOptions& o) {
    auto* c = app.add_subcommand("vessel", "Feed a catheter into a vessel, without a window");
    c->add_option("SCENE", o.scene,
                  "vessel, catheter and the hand's script, TOML: docs/howto/vessel.md")
        ->required();
    c->add_option("--report", o.report, "report, JSON; -: to standard output");
    c->add_option("--csv", o.csv, "measures of each step");
    c->add_option("--frames", o.frames,
                  "folder for wall, ghost and catheter in time (.vtu, .vtp, .pvd)");
    c->add_option("--every", o.every, "steps from frame to frame (default 50)")
        ->check(CLI::Range(1, 1000000));
    c->add_option("--volume", o.volume,
                  "final scan, deformed with the wall (.nrrd, .mha, .nii.gz, .vti …)");
    c->add_option("--png", o.png,
                  "picture of the vessel and the catheter at the end, from outside: the inner "
                  "wall, translucent, in the colours of its displacement (.png)");
    auto* record = c->add_option("--record", o.record, "log of the hand's motion");
    c->add_option("--replay", o.replay, "replay a log instead of the scene's script")
        ->excludes(record);
    c->add_flag("--json", o.json, "print the report instead of a summary");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant vessel scenes/vessel_phantom.toml\n"
        "  pliant vessel aorta.toml --report aorta.json --csv aorta.csv --frames aorta\n"
        "  pliant vessel scenes/vessel_soft.toml --png soft.png\n"
        "  pliant vessel aorta.toml --record aorta.log && pliant vessel aorta.toml --replay "
        "aorta.log");
}

void add_haptics(CLI::App& app, HapticsOptions& o) {
    auto* c = app.add_subcommand("haptics", "Measure the jitter of force feedback on this machine");
    c->add_option("WHAT", o.what, "check, or devices: list known devices")
        ->required()
        ->check(CLI::IsMember({"check", "devices"}));
    c->add_option("--device", o.device,
                  "virtual[:free|spring|tap|active], spacemouse, replay:FILE, or a plug-in's file "
                  "(default virtual:active)");
    c->add_option("--minutes", o.minutes, "how long (default 10)")->check(CLI::Range(0.001, 1e4));
    c->add_option("--rate", o.rate_hz, "of the servo [Hz] (default 1000)")
        ->check(CLI::Range(500.0, 5000.0));
    c->add_option("--update", o.update_hz, "of the tissue [Hz] (default 30)")
        ->check(CLI::Range(1.0, 1000.0));
    c->add_flag("--load", o.load, "push, resample and draw a phantom at the same time");
    c->add_option("--out", o.out, "report, JSON");
    c->add_option("--record", o.record, "positions of the device, for --device replay:FILE");
    c->add_flag("--json", o.json, "say it as one JSON object");
    add_threads(c, o.threads);
    c->footer(
        "Examples:\n"
        "  pliant haptics check --minutes 1\n"
        "  pliant haptics check --load --out servo.json\n"
        "  pliant haptics check --device ./libhaptic_device.so --minutes 0.5\n"
        "  pliant haptics devices");
}

}  // namespace pliant::app
