.PHONY: check images configs

check:
	./.ci/run

# Pictures of README.md, and the settings file that mirrors the source.
images:
	.venv/bin/python docs/make_images.py

configs:
	.venv/bin/python configs/make_default.py
