package cylfuse

import (
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"testing"
)

// TestReadme runs the programs of the README as a module of their own, with the published module that CYLFUSE_GO_MODULE
// names: it must link the library inside.
func TestReadme(t *testing.T) {
	module := os.Getenv("CYLFUSE_GO_MODULE")
	if module == "" {
		t.Skip("CYLFUSE_GO_MODULE, the folder of the published module, is not set: test.sh lays it out")
	}
	readme, err := os.ReadFile("README.md")
	must(t, err)
	programs := strings.Split(string(readme), "```go\npackage main\n")[1:]
	if len(programs) != 2 {
		t.Fatalf("%d programs in the README", len(programs))
	}
	for i, program := range programs {
		program, _, _ = strings.Cut("package main\n"+program, "```")
		if before, _, found := strings.Cut(program, "cylfuse.FitPoints"); found && strings.Count(before, "\n") >= 10 {
			t.Errorf("the fit comes after line 10:\n%s", program)
		}
		folder := t.TempDir()
		must(t, os.WriteFile(filepath.Join(folder, "main.go"), []byte(program), 0o600))
		must(t, os.WriteFile(filepath.Join(folder, "go.mod"), []byte("module smallest\n\ngo 1.19\n\nrequire cylfuse v0.0.0\n\n"+
			"replace cylfuse => "+module+"\n"), 0o600))
		command := exec.Command("go", "run", ".")
		command.Dir = folder
		command.Env = append(os.Environ(), "GOFLAGS=", "CGO_LDFLAGS=")
		output, err := command.CombinedOutput()
		if err != nil {
			t.Fatalf("%v\n%s", err, output)
		}
		if want := []string{"+5.000000e-001\n", "radius 0.0400, length 0.1"}[i]; !strings.Contains(string(output), want) {
			t.Errorf("%q is not in %q", want, output)
		}
	}
}
