# make quickstart   reconstruct the bundled corner of Delft
# make test         run all tests
# Both install what they need first. See README.md.

export PATH := $(CURDIR)/.tools/bin:$(HOME)/.cargo/bin:$(PATH)

DATA := examples/data
MODEL := out/delft.city.json

.PHONY: quickstart test loop setup lint doc bench picture header

quickstart: setup
	cargo build --release --locked
	mkdir -p out
	cargo run --release --locked --quiet -- reconstruct $(DATA)/delft_ahn3.laz --footprints $(DATA)/footprints.geojson -o $(MODEL) --overwrite
	@echo
	@echo "The city model is $(MODEL), in EPSG:7415. Look at it:"
	@echo "  https://ninja.cityjson.org      in the browser: drop the file on the page"
	@echo "  make picture                    as a picture: out/delft.png"

# The tests use the profile of the quick start, so that the heavy libraries are built once.
test: setup
	cargo test --release --locked
	cargo test --locked --manifest-path tools/header/Cargo.toml

# Renews include/gable.h, which is made from src/capi.
header: setup
	GABLE_UPDATE_HEADER=1 cargo test --locked --manifest-path tools/header/Cargo.toml

# From virtual scans to a network to a city model, in small: about five minutes, two of them training.
loop: setup
	sh training/loop.sh

lint: setup
	cargo fmt --check
	cargo clippy --release --locked --all-targets -- -D warnings

doc: setup
	RUSTDOCFLAGS="-D warnings" cargo doc --release --locked --no-deps

bench: setup
	cargo bench --locked

picture: $(MODEL)
	cargo run --release --locked --quiet --example render -- $(MODEL) -o out/delft.png --size 1400

$(MODEL):
	$(MAKE) quickstart

setup:
	@sh scripts/setup.sh
