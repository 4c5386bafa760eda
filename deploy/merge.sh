#!/bin/bash
# Puts the slices in a folder together and writes the report beside them.
#   deploy/merge.sh results
set -euo pipefail
folder=${1:?"the folder of the slices, such as results"}
: "${CNCBF:=cncbf}"
exec "$CNCBF" evaluate --merge "$folder"/evaluation.*-of-*.parquet --out "$folder/evaluation.parquet" --report "$folder/report"
