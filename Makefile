.PHONY: check images configs api

check:
	./.ci/run

# Pictures of README.md, and the settings file that mirrors the source.
images:
	.venv/bin/python docs/make_images.py

configs:
	.venv/bin/python configs/make_default.py

# The API reference in docs/api, from the docstrings.
api:
	.venv/bin/python docs/make_api.py
