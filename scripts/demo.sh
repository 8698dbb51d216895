#!/usr/bin/env bash
# Exports one of the project's scenes from Blender and renders it with the release build, which is there already.
#
#     scripts/demo.sh [SCENE]       SCENE as `scenes/build.py --list` names them; three-objects by default

# shellcheck source=lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"
cd "$project_root"

scene=${1:-three-objects}
folder="$project_root/out/demo"
"$scripts/setup-bpy.sh" 4.5.15
python="${SUNDOG_BPY_PYTHON:-$cache/bpy-4.5.15/bin/python}"

say "exporting the scene $scene from Blender"
"$python" scenes/build.py "$scene" "$folder" >/dev/null ||
    fail "Blender could not make the scene $scene: see the message above."
say "rendering it with Sundog"
# The time is a limit for slow machines; a usual one is done with the samples before.
"$python" scripts/render_scene.py "$folder/$scene.json" -o "$folder/$scene.png" -o "$folder/$scene.exr" \
    --samples 96 --time 50 ||
    fail "the demo was not rendered: see the message above."
echo
echo "The picture is $folder/$scene.png (and, linear with its layers, $folder/$scene.exr)."
echo "The same with a sixth of the samples, denoised: python3 scripts/render_scene.py out/demo/$scene.json -o out/demo/denoised.png --samples 16 --denoise"
