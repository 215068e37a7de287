#!/usr/bin/env bash
# Tests the Python package with target/release/squirm, which must have been built; arguments go to pytest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tools/python-env.sh
. tools/python-env.sh

python_env numpy==2.2.6 mcap==1.6.0 iceoryx2==0.10.0 mcap-protobuf-support==0.6.0 rerun-sdk==0.41.0 \
    matplotlib==3.10.8 pytest==9.0.2 flit_core==3.12.0
# As a user installs it, but with the versions above.
"$python" -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --force-reinstall ./tools/python
"$python" -m pytest --quiet -p no:cacheprovider tools/python/tests "$@"
