# Shared by the commands in this folder, which source it: makes ready the Python environment that
# they run in, and tells where it is.
#
# Sets `root` (the project's folder), `command_name` (for messages), and, after
# `prepare_environment EXTRA...`, `python` (the environment's interpreter).
#
# VERNIER_PYTHON chooses the interpreter: 3.13 (the default, with Blender 5.2), 3.11 (with Blender
# 4.5), or the path of one of these. Without it 3.13 is looked for first, then 3.11.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
command_name=scripts/$(basename "$0")

fail() {
  printf '%s: error: %s\n' "$command_name" "$1" >&2
  exit 2
}

# Prints the version ("3.13") of interpreter $1, or "VERSION lacks WHAT" when a part of it that is
# needed is not installed. Prints nothing when it does not run: version managers put scripts on PATH
# that only say "command not found", so a candidate's name proves nothing.
inspect_python() {
  "$1" -I -c '
import importlib.util, os, sys, sysconfig
missing = [name for name in ("venv", "ensurepip") if importlib.util.find_spec(name) is None]
if not os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")):
    missing.append("Python.h")
version = "%d.%d" % sys.version_info[:2]
print(version + (" lacks " + ", ".join(missing) if missing else ""))
' 2>/dev/null
}

# Prints the places, one a line, where an interpreter of version $1 may be.
python_candidates() {
  local version=$1 pyenv_root
  type -ap "python$version"
  pyenv_root=$(pyenv root 2>/dev/null) || pyenv_root=${PYENV_ROOT:-$HOME/.pyenv}
  local pattern
  for pattern in "$pyenv_root/versions/$version"*/bin/python3 \
    "${XDG_DATA_HOME:-$HOME/.local/share}/uv/python/cpython-$version"*/bin/python3 \
    "$HOME"/{miniconda3,miniforge3,anaconda3}/envs/*/bin/"python$version" \
    "/opt/python/$version"*/bin/python3 "/usr/local/bin/python$version"; do
    [[ -x $pattern ]] && printf '%s\n' "$pattern"
  done
  type -ap python3
}

# Sets `base_python` to a working interpreter of version $1; returns 1 when there is none, with
# `rejected` telling of those that would serve but for a missing part.
find_python() {
  local candidate answer
  while IFS= read -r candidate; do
    answer=$(inspect_python "$candidate") || continue
    if [[ $answer == "$1" ]]; then
      base_python=$candidate
      return 0
    elif [[ $answer == "$1 "* ]]; then
      rejected+="; $candidate is Python $answer"
    fi
  done < <(python_candidates "$1")
  return 1
}

choose_python() {
  local choice=${VERNIER_PYTHON:-} version
  rejected=
  case $choice in
    '' | 3.13 | 3.11)
      for version in ${choice:-3.13 3.11}; do
        python_version=$version
        # A working environment makes the search needless.
        environment=$(environment_folder "$version")
        if [[ $(inspect_python "$environment/bin/python") == "$version" ]]; then
          base_python=$environment/bin/python
          return
        fi
        find_python "$version" && return
      done
      fail "no working CPython ${choice:-3.13 or 3.11} was found${rejected}. Install one (its venv \
module and headers included), or name it: VERNIER_PYTHON=/path/to/python3.13"
      ;;
    *)
      python_version=$(inspect_python "$choice")
      [[ $python_version ]] || fail "VERNIER_PYTHON: $choice does not run"
      [[ $python_version == 3.13 || $python_version == 3.11 ]] ||
        fail "VERNIER_PYTHON: $choice is Python $python_version; 3.13 or 3.11 is needed"
      base_python=$choice
      ;;
  esac
}

# Python 3.13 has `.venv`, 3.11 has `.venv-3.11`: both may exist beside each other.
environment_folder() {
  case $1 in
    3.13) printf '%s/.venv' "$root" ;;
    *) printf '%s/.venv-%s' "$root" "$1" ;;
  esac
}

prepare_environment() {
  [[ $(uname -sm) == 'Linux x86_64' ]] ||
    fail "Linux on x86-64 is needed; this is $(uname -sm)"
  choose_python
  environment=$(environment_folder "$python_version")
  PYTHONPATH=$root/scripts PYTHONDONTWRITEBYTECODE=1 "$base_python" -m vernier_tools.environment \
    --name "$command_name" --root "$root" --environment "$environment" "$@" || exit
  python=$environment/bin/python
}

# Answers --help, in $2 and after, of the command of module $1, and ends. It needs no environment:
# only the list of settings does, and comes with one.
answer_help() {
  local argument
  for argument in "${@:2}"; do
    [[ $argument == -h || $argument == --help ]] || continue
    choose_python
    PYTHONPATH=$root/scripts PYTHONDONTWRITEBYTECODE=1 exec "$base_python" \
      -m vernier_tools.command_lines "$1" --help
  done
}

# Runs module $1 of `vernier_tools` with the other arguments. A crash of the whole process
# (Blender can abort on a file) still ends in one clear line.
run_tool() {
  local module=$1 code
  shift
  PYTHONPATH=$root/scripts:$root "$python" -m "vernier_tools.$module" "$@"
  code=$?
  if ((code > 128)) && ((code != 130 && code != 143)); then
    fail "the process was ended by signal $((code - 128)) ($(kill -l $((code - 128))))"
  fi
  exit $code
}
