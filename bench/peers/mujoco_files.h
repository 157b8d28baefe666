/* A model's description for MuJoCo in several files in memory: its parser does not go deep in one.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef MUJOCO_FILES_H
#define MUJOCO_FILES_H

#include <mujoco/mujoco.h>

#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

/* Elements are appended to one of the files; the first, 0, includes the others. */
class mujoco_files
{
  public:
    enum { LEVELS = 60 }; /* of elements in one another in a file, at most */

    std::vector<std::string> text;

    /* A new file, included where `to` ends. */
    size_t include(size_t to)
    {
        text[to] += "<include file=\"" + std::to_string(text.size()) + ".xml\"/>";
        text.push_back("<mujoco>");
        return text.size() - 1;
    }

    template <typename array> void attribute(size_t to, const char *key, const array &x)
    {
        char number[32];
        text[to] += std::string(" ") + key + "=\"";
        for (double one : x) {
            snprintf(number, sizeof number, "%.17g ", one);
            text[to] += number;
        }
        text[to] += "\"";
    }

    mjModel *load() const
    {
        char error[1000] = "no virtual file";
        const std::unique_ptr<mjVFS> files(new mjVFS);
        mj_defaultVFS(files.get());
        for (size_t k = 0; k < text.size(); ++k) {
            const std::string name = std::to_string(k) + ".xml";
            const int size = (int)text[k].size();
            if (mj_makeEmptyFileVFS(files.get(), name.c_str(), size) != 0) break;
            std::memcpy(files->filedata[mj_findFileVFS(files.get(), name.c_str())], text[k].c_str(),
                        (size_t)size);
        }
        mjModel *m = mj_loadXML("0.xml", files.get(), error, sizeof error);
        mj_deleteVFS(files.get());
        if (!m) throw std::runtime_error(error);
        return m;
    }
};

#endif
