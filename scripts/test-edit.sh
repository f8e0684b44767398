#!/usr/bin/env bash
# Mends buildings in the page of `gable edit` as a person would, by mouse and keys alone, in a headless Chromium. With --pictures
# it also makes docs/howto/edit-*.png on the way, drawn in software so that every machine makes the same pictures. Installs what
# is missing like scripts/test-platforms.sh, and says so where it cannot.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [[ "${1:-}" == --pictures ]]; then
    export EDIT_PICTURES=$PWD/docs/howto
fi
exec bash scripts/test-platforms.sh tests/platforms/edit.test.js tests/platforms/edit.use.test.js
