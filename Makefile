# make quickstart   reconstruct the bundled corner of Delft
# make test         run all tests
# make faults       damaged and hostile inputs, full disks, kills, too much of everything: no breach (half a minute; MINUTES=60)
# make postgis      read footprints from a PostGIS server of its own (installs it; says so where it cannot)
# make remote       read and write objects of an S3 server of its own (installs it; says so where it cannot)
# make pdal         the plugin for PDAL, and the same pipelines in both (says so where there is no PDAL; PDAL_DIR names one)
# make platforms    open what gable writes in CesiumJS, GDAL and a browser (installs them)
# make edit-page    mend buildings in the page of gable edit, in a browser (installs it), and make its pictures with PICTURES=1
# make python       the Python package: a wheel in out/wheels, tested in an environment of its own
# make cluster      a run in several jobs on Dask, Ray, Snakemake and others, with workers killed in the middle
# make plots        curves of noise, smoothness and growth in docs/plots, from measurements (some minutes)
# make site         the documentation, in out/site
# make release      the archive of a release, with checksums, in out/release
# All install what they need first. See README.md and CONTRIBUTING.md.

export PATH := $(CURDIR)/.tools/bin:$(HOME)/.cargo/bin:$(PATH)

DATA := examples/data
MODEL := out/delft.city.json

.PHONY: quickstart test faults postgis remote pdal platforms edit-page python cluster loop setup lint dependencies doc bench plots picture page header release site reference

quickstart: setup
	cargo build --release --locked
	mkdir -p out
	cargo run --release --locked --quiet -- reconstruct $(DATA)/delft_ahn3.laz --footprints $(DATA)/footprints.geojson -o $(MODEL) --overwrite --view
	@echo
	@echo "The city model is $(MODEL), in EPSG:7415. To look at it, open out/delft.html in a browser."

# The tests use the profile of the quick start, so that the heavy libraries are built once.
test: setup
	cargo test --release --locked
	cargo test --locked --manifest-path tools/header/Cargo.toml

# Renews include/gable.h, which is made from src/capi.
header: setup
	GABLE_UPDATE_HEADER=1 cargo test --locked --manifest-path tools/header/Cargo.toml

# A few cases of every kind; with MINUTES=60 as many as fit into an hour. See docs/faults.md for what came out.
faults: setup
	cargo build --release --locked
	python3 scripts/faults $(if $(MINUTES),--minutes $(MINUTES),--quick)

# Says that it was skipped, and why, where there is no PostgreSQL with PostGIS to be had.
postgis: setup
	bash scripts/test-postgis.sh

# Says that it was skipped, and why, where no server that speaks the protocol of S3 can be installed.
remote: setup
	bash scripts/test-remote.sh

# Says that it was skipped, and why, where there is no PDAL.
pdal: setup
	bash scripts/test-pdal.sh

# Says that it was skipped, and why, where what it needs cannot be installed.
platforms: setup
	bash scripts/test-platforms.sh

# Says that it was skipped, and why, where what it needs cannot be installed. PICTURES=1 makes docs/howto/edit-*.png, too.
edit-page: setup
	bash scripts/test-edit.sh $(if $(PICTURES),--pictures)

# Says that it was skipped, and why, where there is no Python 3.10 or no package index.
python: setup
	bash scripts/test-python.sh

# Says that it was skipped, and why, where there is no Python 3.10 or no package index.
cluster: setup
	bash scripts/test-cluster.sh

# From virtual scans to a network to a city model, in small: about five minutes, two of them training.
loop: setup
	sh training/loop.sh

lint: setup
	cargo fmt --check --all
	sh scripts/page.sh --check
	cargo clippy --release --locked --all-targets -- -D warnings
	cargo check --release --locked --no-default-features --features bundled-proj

# Licences of all crates, and known vulnerabilities where the list of them can be fetched.
dependencies: setup
	python3 scripts/dependencies.py

release: setup
	python3 scripts/release.py

doc: setup
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --no-deps

# Says that it was skipped, and why, where what builds it cannot be installed.
site:
	sh scripts/site.sh

# The pages of docs/reference, from the help of the binary.
reference: setup
	cargo build --release --locked
	python3 scripts/reference.py

bench: setup
	cargo bench --locked

# Curves in docs/plots. What this build was measured on before is not measured again; FRESH=--fresh does.
BUILDINGS := 12
plots: setup
	cargo build --release --locked
	$$(sh scripts/setup-plots.sh) scripts/plots.py --buildings $(BUILDINGS) $(FRESH)

# The pictures of the documentation: the page of the quick start, levels of detail, and the steps of the method, in a headless
# Chromium.
picture: $(MODEL)
	sh scripts/picture.sh
	sh scripts/picture.sh out/delft.html docs/page.png 'theme=light&colour=rmse&id=NL.IMBAG.Pand.0503100000017310'
	sh scripts/picture-levels.sh
	sh scripts/picture-terrain.sh
	sh scripts/picture-method.sh

# The pages of gable view, gable explain and gable edit from their sources, by npm: after a change in src/*/page.
page:
	sh scripts/page.sh

$(MODEL):
	$(MAKE) quickstart

setup:
	@sh scripts/setup.sh
