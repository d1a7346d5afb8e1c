//! Examples of `--help`. A test runs every line of them that begins with `earmark`, in a folder with the assets.

pub(crate) const RENDER: &str = "\
Examples:
  A picture, framed by itself, smooth to half a pixel:
    earmark render creature.obj -o creature.png
  Seen from another side, on a dark ground:
    earmark render creature.obj -o side.png --azimuth 90 --background 202428
  What a compositor or a denoiser needs, from the same frame:
    earmark render creature.obj -o a.png --aov depth=d.png --aov face=f.png
  Two models from two sides on one sheet:
    earmark render creature.obj part.obj -o s.png -s 320x320 --views front,top
  From standard input to standard output:
    earmark render - --format obj -o - < cube.obj > cube.png";

pub(crate) const TURNTABLE: &str = "\
Examples:
  One animated PNG, 60 frames at 30 a second:
    earmark turntable creature.obj -o turn.png -s 512x512
  Numbered frames for a video, f_0001.png to f_0024.png:
    earmark turntable creature.obj -o f_####.png -s 320x320 --count 24
  The third quarter of them on another machine:
    earmark turntable creature.obj -o f_####.png --count 24 --frames 13-18";

pub(crate) const REFINE: &str = "\
Examples:
  The control cage after three steps:
    earmark refine creature.obj -o smooth.obj --level 3
  Points on the limit surface with its normals:
    earmark refine creature.obj -o limit.ply --level 3 --limit";

pub(crate) const INFO: &str = "\
Examples:
    earmark info creature.obj
    earmark info part_creased.obj --json";

pub(crate) const COMPARE: &str = "\
Examples:
  Equal, pixel by pixel? The exit code says so:
    earmark compare cube.png cube.png
  Differences as a picture; small ones let pass:
    earmark compare cube.png cube.png --diff d.png --max-delta 2
  A folder of goldens and a folder of new pictures, with a page to look at:
    earmark compare goldens new --report report.html
  Make the new ones golden:
    earmark compare goldens new --accept";

pub(crate) const BATCH: &str = "\
Examples:
  A line per job in jobs.jsonl, as [\"render\", \"cube.obj\", \"-o\", \"a.png\"]:
    earmark batch jobs.jsonl
  The second third of them, without those that are done:
    earmark batch jobs.jsonl --shard 2/3 --skip-existing";

pub(crate) const BENCH: &str = "\
Examples:
    earmark bench frame creature.obj --level 3 --repeat 5
    earmark bench refine creature.obj --level 2 --normals --repeat 5 --json";

pub(crate) const COMPLETIONS: &str = "\
Examples:
    earmark completions bash > earmark.bash
    earmark completions zsh > _earmark";

pub(crate) const MAN: &str = "\
Examples:
    earmark man > earmark.1
    earmark man render > earmark-render.1";
